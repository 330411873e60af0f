"""Drawings in pages: places of paths on a floor, of points of a class, of a score in its limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.results import ScoreResult, TestResult, fraction_of, of_most


def floor_of(
    paths: Mapping[str, Floats], tests: Mapping[str, TestResult], area: tuple[float, float]
) -> tuple[str, float, list[tuple[str, str, str, list[float]]]]:
    """Return the paths (N, 2) of students in a test, for SVG: view, radius of dots, lines.

    A line has title, kind, points and start; lines with all points are the last.
    """
    drawn = sorted(paths, key=lambda student: tests[student].points)
    known = [path[np.isfinite(path).all(axis=1)] for path in map(paths.__getitem__, drawn)]
    corners = np.vstack(known) if any(map(len, known)) else np.array([(0, 0), area])
    low, high = corners.min(axis=0), corners.max(axis=0)
    side = 1.1 * max(*(high - low), 0.2 * max(area))
    left, top = (low + high - side) / 2
    lines = [
        (
            f"{student}: {of_most(test.points, test.most)}",
            shade(test.points, test.most),
            " ".join(f"{x:.1f},{y:.1f}" for x, y in path),
            path[0].round(1).tolist(),
        )
        for student, path in zip(drawn, known, strict=True)
        if len(path) and (test := tests[student])
    ]
    return f"{left:.0f} {top:.0f} {side:.0f} {side:.0f}", side / 160, lines


def shade(points: float, most: float) -> str:
    """Return the class of the style sheet for points."""
    share = fraction_of(points, most)
    return "all" if share == 1 else "some" if share > 0 else "none"


def counts_of(points: Sequence[float], most: float) -> list[int]:
    """Return the number of submissions without points, with each tenth of them, with all."""
    shares = [fraction_of(one, most) for one in points]
    parts = [math.floor(10 * share) + (share > 0) for share in shares]
    return [parts.count(part) for part in range(12)]


_EDGE = 1.15  # room beside the outermost of what is shown, a factor
_WIDEST = 100.0  # what is so many times beyond the limits stands at the edge


def scale_of(score: ScoreResult, runs: Sequence[tuple[float, int, str]]) -> dict[str, Any]:
    """Return zones, runs, result and ticks on a bar, in percent of its width.

    The axis is the logarithm of the statistic: points are linear in it.
    """
    limits = [one for one in (score.low_zero, score.low, score.limit, score.zero) if one]
    least, most = min(limits) / _WIDEST, max(limits) * _WIDEST
    places = [place for place, *_ in runs]
    result = [score.statistic] if math.isfinite(score.statistic) else []
    shown = [*limits, *(min(max(value, least), most) for value in (*places, *result))]
    if score.low is None:
        shown.append(min(1.0, min(limits) / 2))  # as good as the reference
    low, high = min(shown) / _EDGE, max(shown) * _EDGE

    def at(value: float) -> float:
        share = math.log(value / low) / math.log(high / low) if value > 0 else 0.0
        return round(100 * min(max(share, 0.0), 1.0), 2)

    starts = [("all", low), ("some", score.limit), ("none", max(score.limit, score.zero))]
    if score.low is not None and score.low_zero is not None:
        starts[:1] = [("none", low), ("some rising", score.low_zero), ("all", score.low)]
    ends = [*(start for _, start in starts[1:]), high]
    zones = [
        (kind, at(start), round(at(end) - at(start), 2))
        for (kind, start), end in zip(starts, ends, strict=True)
    ]
    return {
        "zones": zones,
        "runs": [(at(place), run, said) for place, run, said in runs],
        "result": [*map(at, result)],
        "ticks": [(f"{limit:.3g}", at(limit)) for limit in limits],
    }
