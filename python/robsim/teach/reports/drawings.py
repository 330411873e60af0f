"""Drawings in HTML: paths on one floor, points of a class, a score between its limits."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.reports.markup import Html, tag
from robsim.teach.results import ScoreResult, fraction_of, number


@dataclass(frozen=True)
class DrawnPath:
    """The path of somebody's best run: positions (N, 2), and the points of the test."""

    student: str
    positions: Floats
    points: float


def floor_of(
    title: str, paths: Sequence[DrawnPath], area: tuple[float, float], most: float
) -> Html:
    """Return the floor with the paths, those with all points on top."""
    left, top, side = _view(paths, area)
    ordered = sorted(paths, key=lambda path: path.points)
    lines = [line for path in ordered if (line := _line(path, most, side / 160))]
    edge = tag("rect", class_="edge", x="0", y="0", width=f"{area[0]:g}", height=f"{area[1]:g}")
    said = f"The best run of each of {len(lines)} submissions, from above; the dot is the start."
    look = {"viewBox": f"{left:.0f} {top:.0f} {side:.0f} {side:.0f}", "role": "img"}
    drawing = tag("svg", edge, *lines, aria_label=f"{title}. {said}", **look)
    head = tag("h3", title), tag("p", said, class_="quiet")
    return tag("figure", *head, drawing, class_="chart floor")


def _view(paths: Sequence[DrawnPath], area: tuple[float, float]) -> tuple[float, float, float]:
    """Return left, top and side of the square of the floor that is shown: around all paths."""
    known = np.vstack([_known(path) for path in paths])
    low, high = np.zeros(2), np.array(area)
    if len(known):
        low, high = known.min(axis=0), known.max(axis=0)
    side = 1.1 * max(*(high - low), 0.2 * max(area))
    left, top = (low + high - side) / 2
    return left, top, side


def _known(path: DrawnPath) -> Floats:
    known: Floats = path.positions[np.isfinite(path.positions).all(axis=1)]
    return known


def _line(path: DrawnPath, most: float, radius: float) -> Html | None:
    known = _known(path)
    if not len(known):
        return None
    kind = shade(path.points, most)
    label = tag("title", f"{path.student}: {number(path.points)} of {number(most)}")
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in known)
    x, y = known[0]
    at = {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{radius:.1f}"}
    start = tag("circle", class_=kind, **at)
    return tag("g", tag("polyline", label, class_=f"path {kind}", points=text), start)


def shade(points: float, most: float) -> str:
    """Return the class of the style sheet for points."""
    share = fraction_of(points, most)
    return "all" if share == 1 else "some" if share > 0 else "none"


_PARTS = 10  # between none and all
_WIDTH, _HEIGHT, _TOP, _BOTTOM = 240, 110, 14, 16
_GAP = 2


def histogram(title: str, points: Sequence[float], most: float) -> Html:
    """Return the histogram of points: none, ten parts, all."""
    counts = _counts(points, most)
    step = _WIDTH / len(counts)
    tall = (_HEIGHT - _TOP - _BOTTOM) / max(*counts, 1)
    base = _HEIGHT - _BOTTOM
    bars = []
    for index, count in enumerate(counts):
        kind = "none" if index == 0 else "all" if index == len(counts) - 1 else "some"
        x, height = index * step + _GAP / 2, count * tall
        box = {"x": f"{x:.1f}", "y": f"{base - height:.1f}", "height": f"{height:.1f}"}
        bars.append(tag("rect", class_=kind, width=f"{step - _GAP:.1f}", rx="2", **box))
        if count:
            middle = {"x": f"{x + step / 2 - _GAP / 2:.1f}", "y": f"{base - height - 3:.1f}"}
            bars.append(tag("text", count, text_anchor="middle", **middle))
    line = tag("line", class_="axis", x1="0", x2=_WIDTH, y1=base, y2=base)
    ends = [
        tag("text", "none", x="0", y=_HEIGHT - 3),
        tag("text", f"all {number(most)}", x=_WIDTH, y=_HEIGHT - 3, text_anchor="end"),
    ]
    said = _said(points, counts, most)
    view = f"0 0 {_WIDTH} {_HEIGHT}"
    drawing = tag("svg", *bars, line, *ends, viewBox=view, role="img", aria_label=said)
    return tag("figure", tag("h3", title), tag("p", said, class_="quiet"), drawing, class_="chart")


def _counts(points: Sequence[float], most: float) -> list[int]:
    counts = [0] * (_PARTS + 2)
    for one in points:
        if one >= most:
            counts[-1] += 1
        elif one <= 0:
            counts[0] += 1
        else:
            counts[1 + min(int(_PARTS * one / most), _PARTS - 1)] += 1
    return counts


def _said(points: Sequence[float], counts: Sequence[int], most: float) -> str:
    if not points:
        return "no submission"
    middle = number(round(statistics.median(points), 2))
    return f"median {middle} of {number(most)}; all points: {counts[-1]}, none: {counts[0]}"


_EDGE = 1.15  # room beside the outermost of what is shown, a factor
_WIDEST = 100.0  # what is so many times beyond the limits stands at the edge


def scale_of(score: ScoreResult) -> Html:
    """Return the bar; its axis is the logarithm of the statistic: points are linear in that."""
    runs = list(_values_of_runs(score))
    low, high = _range(score, [*runs, score.statistic])

    def at(value: float) -> float:
        """Return where a value stands, in percent of the width."""
        logs = np.log([low, high])
        return 100 * float(np.interp(math.log(value), logs, (0, 1))) if value > 0 else 0.0

    zones = [
        tag("i", class_=f"zone {kind}", style=f"left:{at(a):.2f}%;width:{at(b) - at(a):.2f}%")
        for kind, a, b in _zones(score, low, high)
    ]
    dots = [tag("i", class_="run", style=f"left:{at(value):.2f}%") for value in runs]
    mark = []
    if math.isfinite(score.statistic):
        mark = [tag("i", class_="mark", style=f"left:{at(score.statistic):.2f}%")]
    ticks = [
        tag("span", f"{limit:.3g}", class_="tick", style=f"left:{at(limit):.2f}%")
        for limit in _limits(score)
    ]
    bar = tag("div", *zones, *dots, *mark, class_="bar")
    # What it shows stands above it in words.
    return tag("div", bar, tag("div", *ticks, class_="ticks"), class_="scale", aria_hidden="true")


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
