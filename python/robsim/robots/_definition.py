"""The robot definition: image, outline and markers, checked when it is made."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, check_float, check_int, check_name
from robsim._base.text import quoted
from robsim._base.values import digest, frozen
from robsim._core import MarkerLayout, cos, sin
from robsim.imaging._images import Pixels, check_pixels
from robsim.robots._geometry_check import geometry_problems
from robsim.robots._polygon_checks import finite_array, polygon

#: The colours of a robot that names no others.
DEFAULT_COLORS = MarkerLayout(distance=1, offset=0).colors


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDefinition:
    """What a robot looks like from above: a value, which never changes.

    Definitions of the same content are equal and have the same hash. The arrays are read-only
    copies; ``dataclasses.replace(robot, image=...)`` makes another definition.

    Parameters
    ----------
    name : str
        Name of the robot.
    image : array (h, w, 4) of uint8
        Image of the robot, RGBA.
    size : float
        Width of the image on the work area (px).
    alignment : float
        Clockwise rotation of the image (degrees) after which the robot faces right.
    outline, red, blue : array (N, 2)
        Polygons around the robot and its markers (image px): right, down from the centre of the
        top left pixel. The first marker is called ``red`` and the second one ``blue``, whatever
        the `marker_colors` are.
    centre : array (2,), optional
        The robot's centre (image px). Default: the centre of the image.
    maximum_blobs : int
        Number of the largest blobs of each colour among which the markers are searched.
    marker_colors : tuple of 2 str
        Names of the colour classes of the first and of the second marker: those of a colour file,
        such as ``("green", "orange")``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape or is out of range; the message names it.
        Polygons must not intersect themselves, the centre and the markers must lie inside the
        outline, the markers must not overlap.
    """

    name: str
    image: Pixels = field(repr=False)
    size: float
    alignment: float
    outline: Floats = field(repr=False)
    red: Floats = field(repr=False)
    blue: Floats = field(repr=False)
    centre: Floats | None = None
    maximum_blobs: int = 64
    marker_colors: tuple[str, str] = DEFAULT_COLORS

    def __post_init__(self) -> None:
        image = check_pixels("image", self.image, 4)
        check_name("name", self.name)
        check_float("size", self.size, "work-area px", minimum=1, maximum=10_000)
        check_float("alignment", self.alignment, "degrees")
        check_int("maximum_blobs", self.maximum_blobs, minimum=1, maximum=100_000)
        object.__setattr__(self, "marker_colors", check_marker_colors(self.marker_colors))
        height, width = image.shape[:2]
        centre = ((width - 1) / 2, (height - 1) / 2) if self.centre is None else self.centre
        object.__setattr__(self, "image", frozen(image))
        object.__setattr__(self, "centre", frozen(finite_array("centre", centre, (2,))))
        for name in ("outline", "red", "blue"):
            object.__setattr__(self, name, frozen(polygon(name, getattr(self, name))))
        self._check_geometry()

    def _check_geometry(self) -> None:
        height, width = self.image.shape[:2]
        assert self.centre is not None
        problems = geometry_problems(
            width=width,
            height=height,
            centre=self.centre,
            outline=self.outline,
            red=self.red,
            blue=self.blue,
            colors=self.marker_colors,
        )
        if problems:
            raise ValueError("; ".join(problems))
        self.marker_layout()  # raises if the markers share a position

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RobotDefinition):
            return NotImplemented
        return self is other or self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __copy__(self) -> RobotDefinition:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> RobotDefinition:
        return self

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():  # a pickled array is writable again
            kept = frozen(value) if isinstance(value, np.ndarray) else value
            object.__setattr__(self, name, kept)

    @cached_property
    def _content(self) -> tuple[object, ...]:
        """All that the definition says, without its arrays."""
        values = (getattr(self, field.name) for field in fields(self))
        return tuple(digest(v) if isinstance(v, np.ndarray) else v for v in values)

    @property
    def unit(self) -> float:
        """Width of an image pixel on the work area (px)."""
        return float(self.size / self.image.shape[1])

    def to_robot_frame(self, points: ArrayLike) -> Floats:
        """Transform positions in the image into the robot's frame.

        Parameters
        ----------
        points : array (N, 2)
            Positions in the image (px): right, down.

        Returns
        -------
        array (N, 2)
            Positions relative to the robot's centre (work-area px): forward, right.

        Raises
        ------
        ValueError
            If `points` is not an array (N, 2) of finite numbers.
        """
        assert self.centre is not None
        positions = finite_array("points", points, (-1, 2))
        right, down = ((positions - self.centre) * self.unit).T
        alignment = np.deg2rad(self.alignment)
        along, across = cos(alignment), sin(alignment)
        # (forward, right) = R(alignment) (right, down), R clockwise as y points down
        return np.column_stack((along * right - across * down, across * right + along * down))

    @cached_property
    def radius(self) -> float:
        """Maximum distance of the outline from the centre (work-area px)."""
        return float(np.sqrt(np.square(self.to_robot_frame(self.outline)).sum(axis=1)).max())

    def marker_layout(self) -> MarkerLayout:
        """Return the geometry of the markers, by which `locate` finds this robot."""
        return self._marker_layout

    @cached_property
    def _marker_layout(self) -> MarkerLayout:
        return MarkerLayout.from_markers(
            self.to_robot_frame(self.red),
            self.to_robot_frame(self.blue),
            maximum_blobs=self.maximum_blobs,
            colors=self.marker_colors,
        )


def check_marker_colors(names: Any) -> tuple[str, str]:
    """Return the names of the colours of two markers, checked."""
    expected = "marker_colors must be the names of two different colours"
    if not isinstance(names, (tuple, list)):
        raise TypeError(f"{expected}, got {quoted(names)}")
    if len(names) != len(DEFAULT_COLORS):
        raise ValueError(f"{expected}, got {quoted(names)}")
    first, second = (check_name("a name in marker_colors", name) for name in names)
    if first == second:
        raise ValueError(f"{expected}, got {quoted(names)}")
    return first, second
