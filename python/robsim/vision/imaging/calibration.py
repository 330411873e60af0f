"""`Calibration`: a value that maps the pixels of a camera to the floor."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robsim._core import Intrinsics, PlaneMap
from robsim.base.checks import (
    as_float_array,
    check_float,
    check_int,
    check_kind,
    check_mm_per_px,
    check_size,
    is_int,
)
from robsim.base.text import quoted

_MOST = 10**7  # points, pictures
_HIGHEST = 1e5  # mm
_MOST_MARKS = 1000
Feature = str | bool | int | float


@dataclass(frozen=True, kw_only=True)
class Residuals:
    """The fit of a calibration to its data.

    Attributes
    ----------
    rms, worst : float
        Root mean square and largest distance (px of the frame).
    points : int
        Number of points.
    pictures : int
        Number of pictures.
    """

    rms: float
    worst: float
    points: int
    pictures: int = 1

    def __post_init__(self) -> None:
        check_float("rms", self.rms, "px", minimum=0)
        check_float("worst", self.worst, "px", minimum=0)
        check_int("points", self.points, minimum=1, maximum=_MOST)
        check_int("pictures", self.pictures, minimum=1, maximum=_MOST)


_KINDS = {
    **{"intrinsics": Intrinsics, "floor": PlaneMap, "date": datetime.datetime},
    **dict.fromkeys(("lens_residuals", "floor_residuals"), Residuals),
}


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """A camera's lens, and its view of the floor.

    ``robsim calibrate`` makes a calibration, and `save_calibration` writes it to a file.
    ``robsim.Camera`` and `Recording` accept a calibration only for frames of its size. Use its
    `plane_map` for your own frames.

    Parameters
    ----------
    size : tuple of int
        Width and height of the frames (px).
    region : tuple of int, optional
        Left, top, width and height of the part of the sensor in the frames (px). Default: not
        known.
    intrinsics : Intrinsics, optional
        The lens. By default there is no distortion, and the camera's height is not known.
    floor : PlaneMap, optional
        The map of the floor plane, for the pixels of an ideal lens. By default the camera's pose is
        not calibrated yet.
    area : tuple of int, optional
        Width and height of the work area (px); with `floor`.
    mm_per_px : float, optional
        Length of a px of the work area on the floor (mm): the position (x, y) is `mm_per_px` times
        (x, y) from the area's origin. Default: not known.
    marker_height : float
        Height of the robot's markers above the floor (mm).
    lens_residuals, floor_residuals : Residuals, optional
        The fits of both.
    date : datetime.datetime, optional
        Time of the calibration, with its time zone.
    features : mapping of str to str, bool, int or float
        Known settings of the camera, such as its exposure.
    marks : mapping of int to tuple of float
        Pixels (u, v) of the centres of the floor sheets' marks, by their numbers (px). A sheet that
        stays on the floor shows later whether the camera was moved.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names the argument.

    Examples
    --------
    >>> floor = robsim.vision.PlaneMap(np.diag([2.0, 2.0, 1.0]))
    >>> calibration = robsim.vision.Calibration(size=(640, 480), floor=floor, area=(1279, 959))
    >>> calibration.plane_map.to_world((100, 50))
    array([200., 100.])
    """

    size: tuple[int, int]
    region: tuple[int, int, int, int] | None = None
    intrinsics: Intrinsics | None = None
    floor: PlaneMap | None = None
    area: tuple[int, int] | None = None
    mm_per_px: float | None = None
    marker_height: float = 0.0
    lens_residuals: Residuals | None = None
    floor_residuals: Residuals | None = None
    date: datetime.datetime | None = None
    features: Mapping[str, Feature] = field(default_factory=dict, hash=False)
    marks: Mapping[int, tuple[float, float]] = field(default_factory=dict, hash=False, repr=False)
    _plane_map: PlaneMap = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "size", check_size("size", self.size))
        if self.region is not None:
            put(self, "region", check_region("region", self.region))
        for name, kind in _KINDS.items():
            check_kind(name, getattr(self, name), kind, or_none=True)
        if self.date is not None and self.date.tzinfo is None:
            raise ValueError(f"date must have a time zone, got {quoted(self.date)}")
        if self.area is not None:
            put(self, "area", check_size("area", self.area))
        if self.mm_per_px is not None:
            put(self, "mm_per_px", check_mm_per_px(self.mm_per_px))
        height = check_float("marker_height", self.marker_height, "mm", minimum=0, maximum=_HIGHEST)
        put(self, "marker_height", height)
        put(self, "features", _checked_features(self.features))
        put(self, "marks", _checked_marks(self.marks))
        self._check_parts()

    def _check_parts(self) -> None:
        if (self.floor is None) != (self.area is None):
            raise ValueError("floor and area must be given together")
        if self.marker_height and self.intrinsics is None:
            raise ValueError(
                "marker_height must be 0 without intrinsics, because the shift of high markers in "
                "the picture depends on the lens; calibrate the lens first (robsim calibrate "
                "lens), or calibrate the floor with marks at the height of the markers"
            )
        if self.floor is None:
            return
        if self.marker_height and self.mm_per_px is None:
            raise ValueError("marker_height must be 0 without mm_per_px")
        floor = PlaneMap(self.floor.matrix, intrinsics=self.intrinsics)
        height = self.marker_height_px
        object.__setattr__(self, "floor", floor)
        # It refuses a height above the camera.
        try:
            plane_map = floor.at_height(height) if height else floor
        except ValueError as error:
            if not str(error).startswith("height must be below the camera"):
                raise
            raise ValueError(
                f"marker_height must be below the camera, got {self.marker_height:g} mm"
            ) from error
        object.__setattr__(self, "_plane_map", plane_map)

    @property
    def marker_height_px(self) -> float:
        """Height of the markers (work-area px)."""
        return self.marker_height / self.mm_per_px if self.mm_per_px else 0.0

    @property
    def plane_map(self) -> PlaneMap:
        """PlaneMap: the map between frame pixels and the work area, at the height of the markers.

        Raises
        ------
        ValueError
            If the floor is not calibrated yet.
        """
        self.check_floor()
        return self._plane_map

    def check_floor(self) -> None:
        """Raise a ValueError if the floor is not calibrated yet."""
        if self.floor is None:
            raise ValueError(
                "calibration must have a floor, got only a lens: run robsim calibrate floor"
            )

    def check_frames(
        self, size: tuple[int, int], region: tuple[int, int, int, int] | None = None
    ) -> None:
        """Raise a ValueError unless the calibration fits these frames.

        Parameters
        ----------
        size : tuple of int
            Width and height of the frames (px).
        region : tuple of int, optional
            Left, top, width and height of the frames' part of the sensor (px). Default: not known.
        """
        size = check_size("size", size)
        region = None if region is None else check_region("region", region)
        if size != self.size:
            raise ValueError(
                f"the frames have {size[0]} x {size[1]} px, but calibration is for frames of "
                f"{self.size[0]} x {self.size[1]} px: set the camera to the size of the "
                "calibration, or calibrate again"
            )
        if region is None or self.region is None:
            return
        if region != self.region:
            raise ValueError(
                f"the frames show the sensor region {region} (left, top, width, height), but "
                f"calibration is for the region {self.region}: set the camera to the region of the "
                "calibration, or calibrate again"
            )

    def __repr__(self) -> str:
        parts = ["lens"] * (self.intrinsics is not None) + ["floor"] * (self.floor is not None)
        return (
            f"<Calibration: {self.size[0]} x {self.size[1]} px, {' and '.join(parts) or 'empty'}>"
        )


def _checked_features(features: Any) -> dict[str, Feature]:
    if not isinstance(features, Mapping) or len(features) > 100:
        raise TypeError(f"features must be a mapping of at most 100 names, got {quoted(features)}")
    for name, value in features.items():
        if not (isinstance(name, str) and isinstance(value, (str, bool, int, float))):
            raise TypeError(
                f"features must map names to texts or numbers, got {quoted(name)}: {quoted(value)}"
            )
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"features must be finite, got {quoted(name)}: {value}")
    return dict(features)


def _checked_marks(marks: Any) -> dict[int, tuple[float, float]]:
    if not isinstance(marks, Mapping) or len(marks) > _MOST_MARKS:
        raise TypeError(f"marks must be a mapping of at most {_MOST_MARKS}, got {quoted(marks)}")
    checked = {}
    for number, pixel in marks.items():
        mark = check_int("marks", number, minimum=0, maximum=_MOST_MARKS)
        place = as_float_array(f"marks[{mark}]", pixel)
        is_pixel = place.shape == (2,) and np.asarray(pixel).dtype.kind in "iuf"
        if not (is_pixel and (abs(place) < _MOST).all()):
            raise ValueError(f"marks[{mark}] must be a pixel (u, v), got {quoted(pixel)}")
        u, v = place.tolist()
        checked[mark] = (u, v)
    return checked


def check_region(name: str, value: Any) -> tuple[int, int, int, int]:
    """Return a part of a sensor (left, top, width, height), four ints within 0..16384 px."""
    expected = f"{name} must be (left, top, width, height), four ints in px"
    try:
        left, top, width, height = value
    except (TypeError, ValueError):
        raise TypeError(f"{expected}, got {quoted(value)}") from None
    if not all(map(is_int, (left, top, width, height))):
        raise TypeError(f"{expected}, got {quoted(value)}")
    if min(left, top) < 0 or min(width, height) < 1 or max(left, top, width, height) > 16384:
        raise ValueError(f"{expected}, within 0..16384 px, got {quoted(value)}")
    return int(left), int(top), int(width), int(height)
