"""Drawings in pages: paths on a floor, histograms of points, a score in its limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.results import ScoreResult, TestResult, fraction_of

Path = list[list[float]]


def paths_of(paths: Mapping[str, Floats], tests: Mapping[str, TestResult]) -> dict[str, Path]:
    """Return the known positions (x, y) of runs in a test, sorted by points, most last."""
    known = {
        student: path[np.isfinite(path).all(axis=1)].round(1).tolist()
        for student, path in paths.items()
        if student in tests
    }
    order = sorted(known, key=lambda student: (tests[student].points, student))
    return {student: known[student] for student in order if known[student]}


def view_of(paths: Iterable[Path], area: tuple[float, float]) -> tuple[float, float, float]:
    """Return left, top and side of a square around paths on a floor."""
    places = np.vstack([*paths])
    low, high = places.min(axis=0), places.max(axis=0)
    side = 1.1 * max(*(high - low), 0.2 * max(area))
    left, top = (low + high - side) / 2
    return left, top, side


def shade(points: float, most: float) -> str:
    """Return the class of the style sheet for points."""
    share = fraction_of(points, most)
    return "all" if share == 1 else "some" if share > 0 else "none"


def counts_of(points: Sequence[float], most: float) -> list[int]:
    """Return the number of submissions without points, with each tenth of them, with all."""
    edges = [0, 1e-9, *np.arange(1, 11) / 10, 2]
    counts, _ = np.histogram([fraction_of(one, most) for one in points], edges)
    return [*counts.tolist()]


_EDGE = 1.15  # a factor: room around the outermost element
_WIDEST = 100.0  # a factor: elements farther beyond the limits are drawn at the edge
_ZONES = ("none", "some rising", "all", "some", "none")


def scale_of(score: ScoreResult, runs: Sequence[tuple[float, int, str]]) -> dict[str, Any]:
    """Return zones, runs, result and ticks on a bar, in percent of its width.

    The axis is the logarithm of the statistic: points are linear in it.
    """
    limits = [one for one in (score.low_zero, score.low, score.limit, score.zero) if one]
    places = [place for place, *_ in runs]
    result = [score.statistic] if math.isfinite(score.statistic) else []
    # Where points need no lower limit, the reference is shown, too.
    best = [min(1.0, min(limits) / 2)] if score.low is None else []
    near = np.clip([*places, *result], min(limits) / _WIDEST, max(limits) * _WIDEST)
    shown = [*limits, *near, *best]
    ends = min(shown) / _EDGE, max(shown) * _EDGE

    def at(values: Sequence[float]) -> list[float]:
        logarithms = np.log(np.maximum(values, np.finfo(float).tiny))
        return [*np.interp(logarithms, np.log(ends), (0, 100)).round(2).tolist()]

    edges = at([ends[0], *limits, ends[1]])
    widths = np.maximum(np.diff(edges), 0).round(2).tolist()
    return {
        "zones": zip(_ZONES[-len(widths) :], edges, widths, strict=False),
        "runs": [(left, *run) for left, (_, *run) in zip(at(places), runs, strict=True)],
        "result": at(result),
        "ticks": [(f"{limit:.3g}", left) for limit, left in zip(limits, at(limits), strict=True)],
    }
