"""How the points of a class are spread, as a drawing in HTML."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from robsim.teach.assignments.points import number
from robsim.teach.reports.markup import Html, tag

_PARTS = 10  # between none and all
_WIDTH, _HEIGHT, _TOP, _BOTTOM = 240, 110, 14, 16
_GAP = 2


def histogram(title: str, points: Sequence[float], most: float) -> Html:
    """Return the histogram of points: none, ten parts, all.

    Parameters
    ----------
    title : str
        What they are of.
    points : sequence of float
        The points of each submission.
    most : float
        How many there are.
    """
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
