"""A score between its limits, as a bar of HTML: where all points are, where none, and the runs."""

from __future__ import annotations

import math
from collections.abc import Iterable

from robsim.teach.assignments.results import ScoreResult
from robsim.teach.reports.markup import Html, tag

_EDGE = 1.15  # room beside the outermost of what is shown, a factor
_WIDEST = 100.0  # what is so many times beyond the limits stands at the edge


def scale_of(score: ScoreResult) -> Html:
    """Return the bar; its axis is the logarithm of the statistic: points are linear in that."""
    runs = list(_values_of_runs(score))
    low, high = _range(score, [*runs, score.statistic])
    at = _Axis(low, high)
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


class _Axis:
    """Where a value stands, in percent of the width."""

    def __init__(self, low: float, high: float) -> None:
        self._low, self._high = math.log(low), math.log(high)

    def __call__(self, value: float) -> float:
        if value <= 0:
            return 0.0
        part = (math.log(value) - self._low) / (self._high - self._low)
        return 100 * min(max(part, 0.0), 1.0)


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
