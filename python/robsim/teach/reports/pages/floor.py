"""The best paths of a class on one floor, as a drawing in HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim.base.checks import Floats
from robsim.teach.assignments.points import fraction_of, number
from robsim.teach.reports.markup import Html, tag


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
    share = fraction_of(path.points, most)
    kind = "all" if share == 1 else "some" if share > 0 else "none"
    label = tag("title", f"{path.student}: {number(path.points)} of {number(most)}")
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in known)
    x, y = known[0]
    at = {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": f"{radius:.1f}"}
    start = tag("circle", class_=kind, **at)
    return tag("g", tag("polyline", label, class_=f"path {kind}", points=text), start)
