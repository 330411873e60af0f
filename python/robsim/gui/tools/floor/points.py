"""Points on the floor during placement, and the work area; each change can be undone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim.base.checks import Floats, check_float, check_int, check_mm_per_px, check_size
from robsim.base.text import quoted
from robsim.gui.tools.history import History
from robsim.vision.robots.polygon_checks import finite_array

#: Minimum number of points for a map.
FEWEST = 4
MOST = 200
_LARGEST_NUMBER = 10**6
_FARTHEST = 1e6  # mm, or px
_APART = 0.5  # px in the picture, of two points

Place = tuple[float | None, float | None]


@dataclass(frozen=True)
class PlacedPoint:
    """A point of the picture and its position on the floor."""

    number: int  # its name
    pixel: tuple[float, float]  # (u, v)
    place: Place = (None, None)

    @property
    def is_complete(self) -> bool:
        return None not in self.place


@dataclass(frozen=True)
class FloorDraft:
    """A floor calibrated by points, possibly incomplete."""

    area: tuple[int, int]  # width and height (px)
    mm_per_px: float  # of the work area, on the floor
    marker_height: float = 0.0  # of the robot, above the floor (mm)
    points: tuple[PlacedPoint, ...] = field(default=(), repr=False)

    @property
    def complete(self) -> list[PlacedPoint]:
        """The points with known positions."""
        return [one for one in self.points if one.is_complete]

    @property
    def pixels(self) -> Floats:
        """Their positions in the picture, (N, 2)."""
        return np.array([one.pixel for one in self.complete], float).reshape(-1, 2)

    @property
    def places(self) -> Floats:
        """Their positions on the floor (mm), (N, 2)."""
        return np.array([one.place for one in self.complete], float).reshape(-1, 2)

    def problems(self) -> list[str]:
        """Return the problems that prevent a fit, one sentence each."""
        said = []
        if lacking := [str(one.number) for one in self.points if not one.is_complete]:
            numbers = ", ".join(lacking)
            which = f"point {numbers} has" if len(lacking) == 1 else f"points {numbers} have"
            said.append(f"{which} no position on the floor yet: enter x and y")
        missing = FEWEST - len(self.points)
        if missing > 0:
            more = "a point" if missing == 1 else f"{missing} points"
            said.append(f"place {more} more: {FEWEST} are required, 6 reveal a wrong point")
        said += [
            f"points {one} and {other} have the same place on the floor"
            for one, other in _near(self.complete, self.places, 1e-9)
        ]
        pixels = np.array([one.pixel for one in self.points]).reshape(-1, 2)
        said += [
            f"points {one} and {other} coincide in the picture"
            for one, other in _near(self.points, pixels, _APART)
        ]
        return said


def _near(points: Sequence[PlacedPoint], at: Floats, limit: float) -> list[tuple[int, int]]:
    """Return the numbers of the points that are closer together than a limit."""
    apart = np.linalg.norm(at[:, None] - at[None], axis=2)
    pairs = np.argwhere(np.triu(apart < limit, k=1)).tolist()
    return [(points[i].number, points[j].number) for i, j in pairs[:3]]


class FloorPoints(History[FloorDraft]):
    """A floor during the placement of its points."""

    @property
    def draft(self) -> FloorDraft:
        return self._now

    # Points.

    def add(self, pixel: Any, place: Any = (None, None)) -> int:
        """Add a point; return its number."""
        at, where = checked_pixel(pixel), _place(place)
        points = self.draft.points
        if len(points) >= MOST:
            raise ValueError(f"there are already {MOST} points, the maximum")
        number = 1 + max((one.number for one in points), default=0)
        self._change(points=(*points, PlacedPoint(number, at, where)))
        return number

    def put(self, pixels: Any, places: Any) -> None:
        """Replace all points."""
        seen = finite_array("pixels", pixels, (-1, 2))
        where = finite_array("positions", places, (-1, 2))
        if len(seen) != len(where) or len(seen) > MOST:
            raise ValueError(
                f"pixels and positions must have the same length, at most {MOST}, got {len(seen)}, "
                f"{len(where)}"
            )
        both = zip(seen.tolist(), where.tolist(), strict=True)
        self._change(
            points=tuple(
                PlacedPoint(number, checked_pixel(pixel), _place(place))
                for number, (pixel, place) in enumerate(both, start=1)
            )
        )

    def extend(self, found: Sequence[tuple[Any, Any]]) -> None:
        """Add several points with pixel and position, in one change."""
        first = 1 + max((one.number for one in self.draft.points), default=0)
        room = MOST - len(self.draft.points)
        points = [
            PlacedPoint(first + i, checked_pixel(pixel), _place(place))
            for i, (pixel, place) in enumerate(found[:room])
        ]
        self._change(points=(*self.draft.points, *points))

    def move(self, number: int, to: Any, *, goes_on: bool = False) -> None:
        """Move a point; with `goes_on`, one undo reverts this and the previous change."""
        self._replace(number, goes_on=goes_on, pixel=checked_pixel(to))

    def nudge(self, number: int, by: Any, *, goes_on: bool = False) -> None:
        """Move a point by a number of pixels."""
        right, down = finite_array("by", by, (2,)).tolist()
        u, v = self.point(number).pixel
        self.move(number, (u + right, v + down), goes_on=goes_on)

    def place(self, number: int, place: Any) -> None:
        """Set the position of a point on the floor (mm); None = not known."""
        self._replace(number, place=_place(place))

    def remove(self, number: int) -> None:
        """Remove a point."""
        gone = self.point(number)
        self._change(points=tuple(one for one in self.draft.points if one is not gone))

    def clear(self) -> None:
        if self.draft.points:
            self._change(points=())

    def point(self, number: int) -> PlacedPoint:
        number = check_int("point", number, minimum=1, maximum=_LARGEST_NUMBER)
        for one in self.draft.points:
            if one.number == number:
                return one
        raise ValueError(f"unknown point {number}")

    # The work area.

    def adjust(
        self,
        *,
        area: Any = None,
        mm_per_px: float | None = None,
        marker_height: float | None = None,
    ) -> None:
        """Set the given values of the work area."""
        changes: dict[str, Any] = {}
        if area is not None:
            changes["area"] = check_size("area", area)
        if mm_per_px is not None:
            changes["mm_per_px"] = check_mm_per_px(mm_per_px)
        if marker_height is not None:
            changes["marker_height"] = check_float(
                "marker_height", marker_height, "mm", minimum=0, maximum=10_000
            )
        self._change(**changes)

    def _replace(self, number: int, *, goes_on: bool = False, **changes: Any) -> None:
        old = self.point(number)
        new = replace(old, **changes)
        points = tuple(new if one is old else one for one in self.draft.points)
        self._change(goes_on=goes_on, points=points)

    def _change(self, *, goes_on: bool = False, **changes: Any) -> None:
        self.go_to(replace(self.draft, **changes), goes_on=goes_on)


def checked_pixel(value: Any) -> tuple[float, float]:
    """Return a point of a picture (px); ValueError if it is invalid."""
    u, v = finite_array("pixel", value, (2,)).tolist()
    if max(abs(u), abs(v)) > _FARTHEST:
        raise ValueError(f"pixel must lie in the picture, got {quoted(value)}")
    return u, v


def _place(value: Any) -> Place:
    if value is None:
        return None, None
    try:
        x, y = value
    except (TypeError, ValueError):
        raise ValueError(f"position must be (x, y) in mm, got {quoted(value)}") from None
    return _length("position: x", x), _length("position: y", y)


def _length(name: str, value: Any) -> float | None:
    if value is None:
        return None
    return check_float(name, value, "mm", minimum=-_FARTHEST, maximum=_FARTHEST)
