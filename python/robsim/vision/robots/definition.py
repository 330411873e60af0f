"""The robot definition: image, outline and markers, checked on creation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import MarkerLayout, cos, fitting_roles, sin
from robsim.base.checks import Floats, check_float, check_int, check_name, check_words
from robsim.base.text import quoted
from robsim.base.values import Value, frozen
from robsim.vision.imaging.images import Pixels, check_pixels
from robsim.vision.robots.marker_roles import ROLES, ByRole, roles_of
from robsim.vision.robots.polygon_checks import finite_array, geometry_problems, polygon
from robsim.vision.robots.polygons import area_and_centroid

#: The colours of the markers of a robot that names no others.
DEFAULT_COLORS = tuple(MarkerLayout(distance=1, offset=0).colors.values())


@dataclass(frozen=True, eq=False)
class BlobMarker(Value):
    """A marker of one colour, which is visible as a blob; an immutable value.

    Parameters
    ----------
    polygon : array (N, 2)
        Polygon around it (px of the robot's image): right, down from the centre of the top left
        pixel.
    color : str
        Name of its colour class in a colour file. It distinguishes the marker from others.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape; the message names the argument.

    Examples
    --------
    >>> marker = robsim.vision.BlobMarker([(0, 0), (10, 0), (10, 6), (0, 6)], "red")
    >>> marker.color, len(marker.polygon)
    ('red', 4)
    """

    polygon: Floats = field(repr=False)
    color: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "polygon", frozen(polygon("polygon", self.polygon)))
        check_words("color", self.color)


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDefinition(Value):
    """The appearance of a robot from above: an immutable value.

    Definitions with the same content are equal and have the same hash. The arrays are read-only
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
        Clockwise rotation of the image (degrees) that makes the robot face right.
    outline : array (N, 2)
        Polygon around the robot (image px): right, down from the centre of the top left pixel.
    markers : dict of str to BlobMarker
        The two markers by their roles, which give their positions: ``"right"`` and ``"left"``, or
        ``"front"`` and ``"back"``. Their colours must differ.
    centre : array (2,), optional
        The robot's centre (image px). Default: the centre of the image.
    maximum_blobs : int
        Number of the largest blobs of each colour in the search for the markers.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape or is out of range; the message names the
        argument. A polygon must not intersect itself. The centre and the markers must lie inside
        the outline. The markers must not overlap, and their positions after the rotation by
        `alignment` must match their roles.
    """

    name: str
    image: Pixels = field(repr=False)
    size: float
    alignment: float
    outline: Floats = field(repr=False)
    markers: Mapping[str, BlobMarker]
    centre: Floats | None = None
    maximum_blobs: int = 64

    def __post_init__(self) -> None:
        image = check_pixels("image", self.image, 4)
        check_name("name", self.name)
        check_float("size", self.size, "work-area px", minimum=1, maximum=10_000)
        check_float("alignment", self.alignment, "degrees")
        check_int("maximum_blobs", self.maximum_blobs, minimum=1, maximum=100_000)
        height, width = image.shape[:2]
        centre = ((width - 1) / 2, (height - 1) / 2) if self.centre is None else self.centre
        object.__setattr__(self, "image", frozen(image))
        object.__setattr__(self, "centre", frozen(finite_array("centre", centre, (2,))))
        object.__setattr__(self, "outline", frozen(polygon("outline", self.outline)))
        self._check_markers()
        self._check_geometry()

    def _check_markers(self) -> None:
        markers = {role: self.markers[role] for role in roles_of("markers", self.markers)}
        for role, marker in markers.items():
            if not isinstance(marker, BlobMarker):
                raise TypeError(
                    f"markers[{role!r}] must be a robsim.vision.BlobMarker, got {quoted(marker)}"
                )
        check_color_names("colors of markers", [marker.color for marker in markers.values()])
        object.__setattr__(self, "markers", ByRole(markers))

    def _check_geometry(self) -> None:
        height, width = self.image.shape[:2]
        assert self.centre is not None
        problems = geometry_problems(
            width=width,
            height=height,
            centre=self.centre,
            outline=self.outline,
            markers={
                f"{role} marker ({marker.color})": marker.polygon
                for role, marker in self.markers.items()
            },
        )
        if problems:
            raise ValueError("; ".join(problems))
        self.marker_layout()  # raises if the roles are not true

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
        unit = float(self.size / self.image.shape[1])  # of a px of the image (work-area px)
        return _rotated((positions - self.centre) * unit, self.alignment)

    @cached_property
    def radius(self) -> float:
        """Maximum distance of the outline from the centre (work-area px)."""
        return float(np.sqrt(np.square(self.to_robot_frame(self.outline)).sum(axis=1)).max())

    def marker_layout(self) -> MarkerLayout:
        """Return the geometry of the markers, with which `locate` finds this robot."""
        return self._marker_layout

    @cached_property
    def _marker_layout(self) -> MarkerLayout:
        return MarkerLayout.from_markers(
            {role: self.to_robot_frame(marker.polygon) for role, marker in self.markers.items()},
            maximum_blobs=self.maximum_blobs,
            colors={role: marker.color for role, marker in self.markers.items()},
        )


def roles_by_color(polygons: Mapping[str, Floats], alignment: float) -> dict[str, str]:
    """Return the role by colour, first marker first, of polygons (N, 2) in image px.

    The heading, from `alignment` (degrees), decides.
    """
    places = np.array([area_and_centroid(polygon)[1] for polygon in polygons.values()])
    roles = fitting_roles(*_rotated(places, alignment))
    pairs = list(zip(polygons, roles, strict=True))
    return dict(pairs if roles in ROLES else reversed(pairs))


def from_colors(
    markers: Mapping[str, ArrayLike], alignment: float, **parts: Any
) -> RobotDefinition:
    """Return a robot from marker polygons (N, 2), image px, by colour; their roles follow.

    `alignment` and all `parts` are fields of `RobotDefinition`.
    """
    check_float("alignment", alignment, "degrees")
    polygons = {color: polygon(f"markers[{color!r}]", given) for color, given in markers.items()}
    roles = roles_by_color(polygons, alignment)
    return RobotDefinition(
        markers={role: BlobMarker(polygons[color], color) for color, role in roles.items()},
        alignment=alignment,
        **parts,
    )


def by_color(robot: RobotDefinition) -> dict[str, Floats]:
    return {marker.color: marker.polygon for marker in robot.markers.values()}


def check_color_names(argument: str, names: Any) -> tuple[str, str]:
    """Return the names of the colours of two markers, checked."""
    expected = f"{argument} must be the names of two different colours"
    if not isinstance(names, (tuple, list)):
        raise TypeError(f"{expected}, got {quoted(names)}")
    if len(names) != len(DEFAULT_COLORS):
        raise ValueError(f"{expected}, got {quoted(names)}")
    first, second = (check_words(f"a name in {argument}", name) for name in names)
    if first == second:
        raise ValueError(f"{expected}, got {quoted(names)}")
    return first, second


def _rotated(positions: Floats, alignment: float) -> Floats:
    """Rotate positions (N, 2), right and down, by the alignment (degrees): forward, right."""
    right, down = positions.T
    angle = np.deg2rad(alignment)
    along, across = cos(angle), sin(angle)
    # (forward, right) = R(alignment) (right, down), R clockwise as y points down
    return np.column_stack((along * right - across * down, across * right + along * down))
