"""A robot during drawing, by the mouse or by methods; each change can be undone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from robsim.base.checks import check_float, check_int
from robsim.gui.tools.history import History
from robsim.vision.imaging import images
from robsim.vision.robots.polygon_checks import finite_array
from robsim.vision.robots.sketch import Sketch


class RobotDrawing(History[Sketch]):
    """A robot during drawing."""

    @property
    def sketch(self) -> Sketch:
        return self._now

    # Corners.

    def put(self, part: str, polygon: Any, *, goes_on: bool = False) -> None:
        """Replace the polygon of a part; an empty polygon removes the part.

        `goes_on`: the change extends the previous one; one undo reverts both.
        """
        self.go_to(self.sketch.with_part(part, polygon), goes_on=goes_on)

    def move(self, part: str, corner: int, to: Any, *, goes_on: bool = False) -> None:
        corners = self.sketch.part(part).copy()
        corners[self._index(part, corner)] = finite_array("to", to, (2,))
        self.put(part, corners, goes_on=goes_on)

    def insert(self, part: str, corner: int, at: Any) -> None:
        """Insert a corner before corner `corner`; the number of corners = after the last one."""
        corners = self.sketch.part(part)
        corner = check_int("corner", corner, minimum=0, maximum=len(corners))
        self.put(part, np.insert(corners, corner, finite_array("at", at, (2,)), axis=0))

    def remove(self, part: str, corner: int) -> None:
        self.put(part, np.delete(self.sketch.part(part), self._index(part, corner), axis=0))

    # The whole.

    def turn(self, degrees: float) -> None:
        """Turn the heading: the robot faces right after an additional clockwise rotation."""
        turned = self.sketch.alignment + check_float("degrees", degrees, "degrees")
        alignment = float(np.remainder(turned + 180, 360) - 180)
        self.go_to(replace(self.sketch, alignment=alignment))

    def face(self, towards: Any, *, goes_on: bool = False) -> None:
        """Turn the heading from the robot's centre towards a point of the picture."""
        right, down = finite_array("towards", towards, (2,)) - self.sketch.middle
        if np.hypot(right, down) < 1:
            raise ValueError("`towards` must differ from the centre of the robot")
        alignment = float(-np.degrees(np.arctan2(down, right)))
        self.go_to(replace(self.sketch, alignment=alignment), goes_on=goes_on)

    def resize(self, size: float) -> None:
        """Set the width of the picture on the work area (px)."""
        size = check_float("size", size, "px", minimum=1, maximum=10_000)
        self.go_to(replace(self.sketch, size=size))

    def scale(self, one: Any, other: Any, distance: float) -> None:
        """Set the size by two points of the picture and their distance (work-area px)."""
        distance = check_float("distance", distance, "px", exclusive_minimum=0, maximum=10_000)
        apart = finite_array("other", other, (2,)) - finite_array("one", one, (2,))
        pixels = float(np.hypot(*apart))
        if pixels < 1:
            raise ValueError("`one` and `other` must be at least one pixel apart")
        self.resize(distance / pixels * self.sketch.image.shape[1])

    def _index(self, part: str, corner: int) -> int:
        return check_int("corner", corner, minimum=0, maximum=len(self.sketch.part(part)) - 1)


def cut_out(image: images.Pixels, square: tuple[float, float, float]) -> images.Pixels:
    """Return a square of a picture: its centre and side (px)."""
    u, v, side = square
    count = round(side)
    left, top = (round(middle - side / 2) for middle in (u, v))
    height, width = image.shape[:2]
    left, top = min(max(left, 0), width - count), min(max(top, 0), height - count)
    return np.array(image[top : top + count, left : left + count])
