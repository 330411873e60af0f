"""The best paths of a class on one floor, as a drawing in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._base.checks import Floats
from robsim.assignments._reports.markup import Html, tag
from robsim.assignments._reports.points import fraction_of, number

_WIDTH = 1000  # of the drawing
_MARGIN = 20


@dataclass(frozen=True)
class DrawnPath:
    """The path of somebody's best run: positions (N, 2), and the points of the test."""

    student: str
    positions: Floats
    points: float


def floor_of(
    title: str, paths: Sequence[DrawnPath], area: tuple[float, float], most: float
) -> Html:
    """Return the floor with the paths: those with all points on top.

    Parameters
    ----------
    title : str
        Title of the test.
    paths : sequence of DrawnPath
        The paths.
    area : tuple of float
        Width and height of the work area, in the unit of the positions.
    most : float
        Points of the test.
    """
    scale = _WIDTH / area[0]
    height = area[1] * scale
    ordered = sorted(paths, key=lambda path: path.points)
    lines = [line for path in ordered if (line := _line(path, scale, most))]
    edge = tag("rect", class_="edge", x="0", y="0", width=_WIDTH, height=f"{height:.0f}", rx="8")
    view = f"{-_MARGIN} {-_MARGIN} {_WIDTH + 2 * _MARGIN} {height + 2 * _MARGIN:.0f}"
    said = f"The best run of each of {len(lines)} submissions, from above; the dot is the start."
    drawing = tag("svg", edge, *lines, viewBox=view, role="img", aria_label=f"{title}. {said}")
    head = tag("h3", title), tag("p", said, class_="quiet")
    return tag("figure", *head, drawing, class_="chart floor")


def _line(path: DrawnPath, scale: float, most: float) -> Html | None:
    known = path.positions[np.isfinite(path.positions).all(axis=1)] * scale
    if not len(known):
        return None
    share = fraction_of(path.points, most)
    kind = "all" if share == 1 else "some" if share > 0 else "none"
    label = tag("title", f"{path.student}: {number(path.points)} of {number(most)}")
    text = " ".join(f"{x:.0f},{y:.0f}" for x, y in known)
    x, y = known[0]
    start = tag("circle", cx=f"{x:.0f}", cy=f"{y:.0f}", r="6", class_=kind)
    return tag("g", tag("polyline", label, class_=f"path {kind}", points=text), start)
