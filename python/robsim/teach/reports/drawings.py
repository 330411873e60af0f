"""Drawings in pages: places of paths on a floor, of points of a class, of a score in its limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.results import ScoreResult, fraction_of, number


@dataclass(frozen=True)
class DrawnPath:
    """The path of somebody's best run: positions (N, 2), and the points of the test."""

    student: str
    positions: Floats
    points: float


@dataclass(frozen=True)
class Floor:
    """A floor with paths as in SVG: title, kind and points of each, those with all points last."""

    title: str
    view: str
    radius: float  # of the dot at a start
    area: tuple[float, float]
    lines: Sequence[tuple[str, str, str, Sequence[float]]]


def floor_of(
    title: str, paths: Sequence[DrawnPath], area: tuple[float, float], most: float
) -> Floor:
    """Return the floor with the paths, those with all points on top, and the view around all."""
    ordered = sorted(paths, key=lambda path: path.points)
    known = [path.positions[np.isfinite(path.positions).all(axis=1)] for path in ordered]
    low, high = np.zeros(2), np.array(area)
    if len(everywhere := np.vstack(known)):
        low, high = everywhere.min(axis=0), everywhere.max(axis=0)
    side = 1.1 * max(*(high - low), 0.2 * max(area))
    left, top = (low + high - side) / 2
    lines = [
        (
            f"{path.student}: {number(path.points)} of {number(most)}",
            shade(path.points, most),
            " ".join(f"{x:.1f},{y:.1f}" for x, y in places),
            places[0].round(1).tolist(),
        )
        for path, places in zip(ordered, known, strict=True)
        if len(places)
    ]
    return Floor(title, f"{left:.0f} {top:.0f} {side:.0f} {side:.0f}", side / 160, area, lines)


def shade(points: float, most: float) -> str:
    """Return the class of the style sheet for points."""
    share = fraction_of(points, most)
    return "all" if share == 1 else "some" if share > 0 else "none"


_PARTS = 10  # between none and all


def counts_of(points: Sequence[float], most: float) -> list[int]:
    """Return the number of submissions without points, with each tenth of them, with all."""
    counts = [0] * (_PARTS + 2)
    for one in points:
        share = fraction_of(one, most)
        counts[-1 if share == 1 else math.floor(_PARTS * share) + 1 if share > 0 else 0] += 1
    return counts


_EDGE = 1.15  # room beside the outermost of what is shown, a factor
_WIDEST = 100.0  # what is so many times beyond the limits stands at the edge


@dataclass(frozen=True)
class Scale:
    """A score between its limits; places are in percent of the width, from the left."""

    zones: Sequence[tuple[str, float, float]]  # kind, left, width
    runs: Sequence[float]
    result: Sequence[float]
    ticks: Sequence[tuple[str, float]]  # limit, left


def scale_of(score: ScoreResult) -> Scale:
    """Return the bar; its axis is the logarithm of the statistic: points are linear in that."""
    runs = list(_values_of_runs(score))
    low, high = _range(score, [*runs, score.statistic])

    def at(value: float) -> float:
        share = math.log(value / low) / math.log(high / low) if value > 0 else 0.0
        return round(100 * min(max(share, 0.0), 1.0), 2)

    zones = [(kind, at(a), round(at(b) - at(a), 2)) for kind, a, b in _zones(score, low, high)]
    result = [at(score.statistic)] if math.isfinite(score.statistic) else []
    ticks = [(f"{limit:.3g}", at(limit)) for limit in _limits(score)]
    return Scale(zones, [*map(at, runs)], result, ticks)


def _values_of_runs(score: ScoreResult) -> Iterable[float]:
    """Return what each run came to, on the axis of the statistic."""
    if score.low is not None:
        yield from filter(math.isfinite, score.values)
        return
    for value, reference in zip(score.values, score.reference, strict=False):
        if math.isfinite(value) and math.isfinite(reference) and reference > 0:
            yield value / reference


def _limits(score: ScoreResult) -> list[float]:
    limits = [score.low_zero, score.low, score.limit, score.zero]
    return [limit for limit in limits if limit is not None and limit > 0]


def _range(score: ScoreResult, values: list[float]) -> tuple[float, float]:
    limits = _limits(score) or [1.0]
    least, most = min(limits) / _WIDEST, max(limits) * _WIDEST
    shown = [*limits, *(min(max(v, least), most) for v in values if math.isfinite(v))]
    if score.low is None:
        shown.append(min(1.0, min(limits) / 2))  # as good as the reference
    return min(shown) / _EDGE, max(shown) * _EDGE


def _zones(score: ScoreResult, low: float, high: float) -> Iterable[tuple[str, float, float]]:
    start = low
    if score.low is not None and score.low_zero is not None:
        yield "none", low, score.low_zero
        yield "some rising", score.low_zero, score.low
        start = score.low
    yield "all", start, score.limit
    if score.zero > score.limit:
        yield "some", score.limit, score.zero
    yield "none", max(score.zero, score.limit), high
