"""Robot definitions: picture, outline, markers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._core import Locator
from robsim.pictures import Pixels, read_picture
from robsim.shipped import ASSETS, read_toml

Floats = NDArray[np.float64]

_KEYS = {"name", "image", "size", "alignment", "centre", "outline", "red", "blue"}


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDefinition:
    """What a robot looks like from above.

    Parameters
    ----------
    name : str
        Name of the robot.
    image : array (h, w, 4) of uint8
        Picture of the robot, RGBA.
    size : float
        Work-area px that the width of the picture stands for.
    alignment : float
        Degrees clockwise that turn the picture so that the robot faces right.
    outline, red, blue : array (N, 2)
        Polygons of the robot and of its markers in picture pixels: right, down from the centre of
        the top left pixel.
    centre : array (2,), optional
        The robot's centre in picture pixels. Default: the centre of the picture.

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it.
    """

    name: str
    image: Pixels = field(repr=False)
    size: float
    alignment: float
    outline: Floats = field(repr=False)
    red: Floats = field(repr=False)
    blue: Floats = field(repr=False)
    centre: Floats | None = None

    def __post_init__(self) -> None:
        image = np.asarray(self.image)
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 4 or not image.size:
            raise ValueError(
                f"image must be a uint8 array of shape (h, w, 4), got {image.dtype} of shape "
                f"{image.shape}"
            )
        if not isinstance(self.name, str):
            raise TypeError(f"name must be text, got {self.name!r}")
        if not 1 <= _number("size", self.size) <= 10_000:
            raise ValueError(f"size must lie within 1..10000 work-area px, got {self.size}")
        if not np.isfinite(_number("alignment", self.alignment)):
            raise ValueError(f"alignment must be finite (degrees), got {self.alignment}")
        height, width = image.shape[:2]
        centre = ((width - 1) / 2, (height - 1) / 2) if self.centre is None else self.centre
        object.__setattr__(self, "image", image)
        object.__setattr__(self, "centre", _numbers("centre", centre, (2,)))
        for name in ("outline", "red", "blue"):
            object.__setattr__(self, name, _polygon(name, getattr(self, name)))
        self.locator()  # refuses markers in one place

    @property
    def unit(self) -> float:
        """Work-area px that a pixel of the picture stands for."""
        return float(self.size / self.image.shape[1])

    def to_robot_frame(self, points: ArrayLike) -> Floats:
        """Return places of the picture in the robot's frame.

        Parameters
        ----------
        points : array (N, 2)
            Picture pixels: right, down.

        Returns
        -------
        array (N, 2)
            Forward, right of the robot's centre (work-area px).
        """
        assert self.centre is not None
        places = _numbers("points", points, (-1, 2))
        right, down = ((places - self.centre) * self.unit).T
        cos, sin = np.cos(np.deg2rad(self.alignment)), np.sin(np.deg2rad(self.alignment))
        # a turn of the picture by `alignment`, clockwise
        return np.column_stack((cos * right - sin * down, sin * right + cos * down))

    @property
    def radius(self) -> float:
        """Distance of the farthest point of the outline from the centre (work-area px)."""
        return float(np.linalg.norm(self.to_robot_frame(self.outline), axis=1).max())

    def locator(self) -> Locator:
        """Return the locator that finds this robot by its markers."""
        return Locator.from_markers(self.to_robot_frame(self.red), self.to_robot_frame(self.blue))


def load_robot(robot: str | PathLike[str] = "lab") -> RobotDefinition:
    """Read a robot definition.

    Parameters
    ----------
    robot : str or path
        Name of a robot that ships with robsim, or a folder with a ``robot.toml``.

    Raises
    ------
    ValueError
        If there is no such robot, or its files do not define one; the message says where.
    """
    folder = ASSETS / "robots" / robot
    if not (folder / "robot.toml").is_file():
        folder = Path(robot)
    file = folder / "robot.toml"
    if not file.is_file():
        raise ValueError(
            f"no robot {str(robot)!r}: there are {', '.join(robot_names())}, or give a folder "
            "with a robot.toml"
        )
    try:
        return _from_values(folder, read_toml(file))
    except (ValueError, TypeError, OSError) as error:
        raise ValueError(f"robot definition {file}: {error}") from error


def robot_names() -> list[str]:
    """Return the names of the robots that ship with robsim."""
    return sorted(file.parent.name for file in (ASSETS / "robots").glob("*/robot.toml"))


def as_robot(robot: str | PathLike[str] | RobotDefinition) -> RobotDefinition:
    """Return the robot definition itself, or the one of a name or folder."""
    if isinstance(robot, RobotDefinition):
        return robot
    if isinstance(robot, (str, PathLike)):
        return load_robot(robot)
    raise TypeError(f"robot must be a name, a folder or a RobotDefinition, got {robot!r}")


def _from_values(folder: Path, values: dict[str, Any]) -> RobotDefinition:
    missing = _KEYS - {"centre"} - set(values)
    unknown = set(values) - _KEYS
    if missing or unknown:
        what = [f"{key} is missing" for key in sorted(missing)]
        what += [f"{key} is not known" for key in sorted(unknown)]
        raise ValueError("; ".join(what))
    if not isinstance(values["image"], str):
        raise TypeError(f"image must be the name of a file, got {values['image']!r}")
    return RobotDefinition(
        **{**values, "image": read_picture(folder / values["image"], mode="RGBA")}
    )


def _number(name: str, value: Any) -> float:
    """Return a plain number."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} must be a number, got {value!r}")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _numbers(name: str, value: Any, shape: tuple[int, ...]) -> Floats:
    """Return finite numbers of a shape; -1 = any size."""
    message = f"{name} must be finite numbers of shape {shape}, got {value!r}"
    try:
        numbers = np.asarray(value)
    except (TypeError, ValueError):
        raise ValueError(message) from None
    if numbers.dtype.kind not in "iuf" or numbers.ndim != len(shape):
        raise ValueError(message)
    if any(size not in (-1, got) for size, got in zip(shape, numbers.shape, strict=True)):
        raise ValueError(message)
    if not np.isfinite(numbers).all():
        raise ValueError(message)
    return numbers.astype(np.float64)


def _polygon(name: str, value: Any) -> Floats:
    polygon = _numbers(name, value, (-1, 2))
    if len(polygon) < 3:
        raise ValueError(f"{name} must be a polygon of at least 3 points, got {len(polygon)}")
    x, y = (polygon - polygon[0]).T
    if abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 1e-9:
        raise ValueError(f"{name} must be a polygon with an area, got points on a line")
    return polygon
