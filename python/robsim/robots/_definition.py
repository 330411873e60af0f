"""The robot definition: image, outline, markers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, check_float, check_int
from robsim._core import MarkerLayout
from robsim.imaging._images import Pixels
from robsim.robots._geometry_check import geometry_problems
from robsim.robots._polygon_checks import numbers, polygon


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDefinition:
    """What a robot looks like from above.

    Parameters
    ----------
    name : str
        Name of the robot.
    image : array (h, w, 4) of uint8
        Image of the robot, RGBA.
    size : float
        Work-area px that the width of the image stands for.
    alignment : float
        Degrees clockwise that turn the image so that the robot faces right.
    outline, red, blue : array (N, 2)
        Polygons of the robot and of its markers in image pixels: right, down from the centre of
        the top left pixel.
    centre : array (2,), optional
        The robot's centre in image pixels. Default: the centre of the image.
    maximum_blobs : int
        The markers looks at so many of the largest blobs of a colour.

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it. Polygons must not cross themselves, the
        centre and the markers must lie inside the outline, the markers must not overlap.
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

    def __post_init__(self) -> None:
        image = np.asarray(self.image)
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 4 or not image.size:
            raise ValueError(
                f"image must be a uint8 array of shape (h, w, 4), got {image.dtype} of shape "
                f"{image.shape}"
            )
        if not isinstance(self.name, str):
            raise TypeError(f"name must be text, got {self.name!r}")
        check_float("size", self.size, "work-area px", minimum=1, maximum=10_000)
        check_float("alignment", self.alignment, "degrees")
        check_int("maximum_blobs", self.maximum_blobs, minimum=1, maximum=100_000)
        height, width = image.shape[:2]
        centre = ((width - 1) / 2, (height - 1) / 2) if self.centre is None else self.centre
        object.__setattr__(self, "image", image)
        object.__setattr__(self, "centre", numbers("centre", centre, (2,)))
        for name in ("outline", "red", "blue"):
            object.__setattr__(self, name, polygon(name, getattr(self, name)))
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
        )
        if problems:
            raise ValueError("; ".join(problems))
        self.marker_layout()  # refuses markers in one place

    @property
    def unit(self) -> float:
        """Work-area px that a pixel of the image stands for."""
        return float(self.size / self.image.shape[1])

    def to_robot_frame(self, points: ArrayLike) -> Floats:
        """Return places of the image in the robot's frame.

        Parameters
        ----------
        points : array (N, 2)
            Image pixels: right, down.

        Returns
        -------
        array (N, 2)
            Forward, right of the robot's centre (work-area px).
        """
        assert self.centre is not None
        places = numbers("points", points, (-1, 2))
        right, down = ((places - self.centre) * self.unit).T
        cos, sin = np.cos(np.deg2rad(self.alignment)), np.sin(np.deg2rad(self.alignment))
        # a turn of the image by `alignment`, clockwise
        return np.column_stack((cos * right - sin * down, sin * right + cos * down))

    @property
    def radius(self) -> float:
        """Distance of the farthest point of the outline from the centre (work-area px)."""
        return float(np.linalg.norm(self.to_robot_frame(self.outline), axis=1).max())

    def marker_layout(self) -> MarkerLayout:
        """Return the markers that finds this robot by its markers."""
        return MarkerLayout.from_markers(
            self.to_robot_frame(self.red),
            self.to_robot_frame(self.blue),
            maximum_blobs=self.maximum_blobs,
        )
