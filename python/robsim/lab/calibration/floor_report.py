"""The report of a calibrated floor: residuals, and the name of the worst point."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from robsim.base.checks import Floats
from robsim.base.report import Column, Problem, Quantity, Report, Row, Table
from robsim.base.text import listed
from robsim.vision.imaging.calibration import Calibration

_RMS = (1.0, 3.0)  # px of the frame: good, poor
_FAR = (2.0, 5.0)  # expected error in the corners of the area, work-area px: good, poor
_SCALE = 0.005  # of the print
_PLACE = 10.0  # mm
_STILL = 1.0  # px
#: Numbers of points more than parameters, with which a wrong point shows.
TELLING = 4
_MANY = 8  # points; of fewer, a wrong one need not fit worst


@dataclass(frozen=True)
class FloorPoint:
    """A point on the floor, used for a calibration.

    Attributes
    ----------
    name : str
        Its name.
    pixel : tuple of float
        Position in the picture: (u, v).
    place : tuple of float
        Position on the floor, from the top left corner of the work area (mm).
    mm, px : float
        Deviation of the map on the floor (mm) and in the picture (px).
    is_used : bool
        False: the point does not fit the others, and was left out.

    Examples
    --------
    >>> pixels = [(0, 0), (640, 0), (640, 480), (0, 480), (320, 240)]
    >>> positions = 2.0 * np.array(pixels)
    >>> found = robsim.lab.calibrate_floor(
    ...     pixels, positions, area=(1280, 960), mm_per_px=1.0, size=(640, 480)
    ... )
    >>> point = found.points[1]
    >>> point.pixel, point.place
    ((640.0, 0.0), (1280.0, 0.0))
    """

    name: str
    pixel: tuple[float, float]
    place: tuple[float, float]
    mm: float
    px: float
    is_used: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorCalibration(Report):
    """The result of `calibrate_floor` and `calibrate_floor_by_sheets`.

    Attributes
    ----------
    calibration : Calibration
        Lens and floor, as a value.
    points : tuple of FloorPoint
        The points of the calibration.
    expected_errors : array (4,)
        Expected standard deviation of the map in the corners of the work area, clockwise from
        the top left (mm). NaN = too few points for an estimate.
    places_off : mapping of int to float
        Distance of each sheet's cross from its measured position (mm), by number.
    print_scale : float
        Measured distances between sheets, divided by the distances expected from the size of
        their marks.
    moved : float
        Motion of a corner from picture to picture (px).

    Examples
    --------
    >>> pixels = [(0, 0), (640, 0), (640, 480), (0, 480), (320, 240)]
    >>> positions = 2.0 * np.array(pixels)
    >>> found = robsim.lab.calibrate_floor(
    ...     pixels, positions, area=(1280, 960), mm_per_px=1.0, size=(640, 480)
    ... )
    >>> found.calibration.plane_map.to_world((100, 50)).round(3)
    array([200., 100.])
    """

    calibration: Calibration
    points: tuple[FloorPoint, ...] = field(repr=False)
    expected_errors: Floats = field(repr=False)
    places_off: Mapping[int, float] = field(default_factory=dict)
    print_scale: float = 1.0
    moved: float = 0.0

    @property
    def title(self) -> str:
        """Name of the calibrated object."""
        return "Calibration of the floor"

    @property
    def rms(self) -> float:
        """Root mean square distance of the points from their mapped positions (px)."""
        residuals = self.calibration.floor_residuals
        assert residuals is not None  # of `calibrate_floor`
        return residuals.rms

    @property
    def rms_mm(self) -> float:
        """Root mean square distance of the points on the floor (mm)."""
        return math.sqrt(float(np.mean([one.mm**2 for one in self._used])))

    @property
    def worst(self) -> FloorPoint:
        """The point with the worst fit."""
        return max(self.points, key=lambda one: one.px)

    @property
    def _used(self) -> list[FloorPoint]:
        return [one for one in self.points if one.is_used]

    @property
    def verdict(self) -> str:
        """``"good"``, ``"poor"``, ``"bad"``, or ``"not checked"`` with four points and no lens."""
        if self.rms > _RMS[1] or self._expected_px > _FAR[1]:
            return "bad"
        if self.problems:
            return "poor"
        return "not checked" if self._fits_exactly else "good"

    @property
    def _fits_exactly(self) -> bool:
        """Whether the points are too few to contradict each other."""
        return bool(np.isnan(self.expected_errors).any())

    @property
    def _expected_px(self) -> float:
        """Largest expected error in a corner of the area (work-area px); 0 = not known."""
        scale = self.calibration.mm_per_px
        assert scale is not None
        found = float(np.max(self.expected_errors)) / scale
        return 0.0 if math.isnan(found) else found

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Residuals and expected errors."""
        residuals = self.calibration.floor_residuals
        assert residuals is not None
        height = self.calibration.marker_height
        worst = (
            Quantity("worst", "worst", self.worst.name),
            Quantity("worst_mm", "its deviation", self.worst.mm, "mm", ".1f"),
        )
        return (
            Quantity("rms", "rms", self.rms, "px", ".2f"),
            Quantity("rms_mm", "rms on the floor", self.rms_mm, "mm", ".1f"),
            *(worst if self._tells_wrong else ()),
            Quantity("n_points", "points used", residuals.points),
            Quantity("n_pictures", "pictures", residuals.pictures),
            Quantity(
                "expected_error",
                "expected error in the corners of the area, up to",
                float(np.max(self.expected_errors)),
                "mm",
                ".1f",
            ),
            Quantity("marker_height", "height of the markers", height, "mm"),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The points, or each sheet with all its corners."""
        columns = (
            Column("points", "points", unit=""),
            Column("mm", "off by", unit="mm", format=".1f"),
            Column("px", "in the picture", unit="px", format=".2f"),
            Column("used", "used", unit=""),
        )
        rows = []
        for name in dict.fromkeys(one.name for one in self.points):
            same = [one for one in self.points if one.name == name]
            mm, px = np.sqrt(np.mean([(one.mm**2, one.px**2) for one in same], axis=0)).tolist()
            rows.append(Row(name, (len(same), mm, px, "yes" if same[0].is_used else "no")))
        return (Table(key="points", columns=columns, rows=rows, row_title="point"),)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Problems and remedies."""
        return tuple(Problem(kind=kind, sentence=text) for kind, text in self._problems())

    def _problems(self) -> Iterator[tuple[str, str]]:
        for one in self.points:
            if not one.is_used:
                yield (
                    "wrong point",
                    f"point {one.name} is {one.mm:.0f} mm off and was left out: check its position "
                    f"({one.place[0]:g}, {one.place[1]:g} mm) and its pixel",
                )
        worst = max(self._used, key=lambda one: one.px)
        if self.rms > _RMS[0]:
            point = "" if worst.name.startswith("sheet") else "point "
            who = (
                f"{point}{worst.name} fits worst, {worst.mm:.0f} mm off: check its position"
                f"{self._others_hint}"
                if self._tells_wrong
                else f"one point of {len(self._used)} is wrong: another point separates it from "
                "all others"
            )
            yield (
                "rms",
                f"rms {self.rms:.1f} px, expected is below {_RMS[0]:g}; {who}{self._lens_hint}",
            )
        if self._expected_px > _FAR[0]:
            yield (
                "extrapolated",
                f"in a corner of the area the map may be {np.max(self.expected_errors):.0f} mm "
                "off: spread marks or sheets over the whole area",
            )
        yield from self._sheet_problems()

    def _sheet_problems(self) -> Iterator[tuple[str, str]]:
        if self.places_off:
            number, off = max(self.places_off.items(), key=lambda item: item[1])
            if off > _PLACE:
                yield (
                    "place",
                    f"sheet {number} is {off:.0f} mm off: measure the position of its cross again",
                )
        if abs(self.print_scale - 1) > _SCALE:
            yield (
                "print",
                f"the sheets are {100 * abs(self.print_scale - 1):.1f} % farther "
                f"{'apart' if self.print_scale > 1 else 'together'} than the size of their marks "
                "indicates: were they printed at 100 %? Measure a mark, and pass --mark",
            )
        if self.moved > _STILL:
            yield (
                "moved",
                f"the marks moved by {self.moved:.1f} px from picture to picture: the camera "
                "must be stationary",
            )

    @property
    def _tells_wrong(self) -> bool:
        """Whether there are enough points to identify a wrong one."""
        parameters = 8 if self.calibration.intrinsics is None else 6
        return 2 * len(self.points) - parameters >= TELLING

    @property
    def _others_hint(self) -> str:
        return " and all others, as so few share the error" if len(self._used) < _MANY else ""

    @property
    def _lens_hint(self) -> str:
        if self.calibration.intrinsics is None:
            return ", or does the lens distort? Then calibrate it first (robsim calibrate lens)"
        return ""

    @property
    def remarks(self) -> tuple[str, ...]:
        """Limits of the calibration."""
        said = []
        if self._fits_exactly:
            said.append("four points fit exactly, right or wrong: a fifth point checks them")
        if self.calibration.intrinsics is None:
            said.append(
                "without a lens, the height of the markers cannot be accounted for, and distortion "
                "is not"
            )
        missing = self._unseen_corners()
        if missing:
            said.append(f"the picture lacks the area's corner at the {listed(missing)}")
        return tuple(said)

    def _unseen_corners(self) -> list[str]:
        width, height = self.calibration.area or (0, 0)
        corners = np.array([(0, 0), (width, 0), (width, height), (0, height)], float) - 0.5
        pixels = self.calibration.plane_map.to_pixel(corners)
        size = np.array(self.calibration.size)
        is_inside = (pixels >= -0.5) & (pixels <= size - 0.5)  # NaN is not
        names = ("top left", "top right", "bottom right", "bottom left")
        return [name for name, seen in zip(names, is_inside.tolist(), strict=True) if not all(seen)]
