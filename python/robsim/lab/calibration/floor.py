"""`calibrate_floor` and `calibrate_floor_by_sheets`: the camera's view of the floor."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Frame, PlaneMap
from robsim.base.checks import (
    Floats,
    as_float_array,
    check_float,
    check_int,
    check_kind,
    check_mm_per_px,
    check_size,
)
from robsim.base.text import listed, quoted
from robsim.lab.calibration._plane_fit import PlaneFit, aligned, fit_plane
from robsim.lab.calibration.floor_report import TELLING, FloorCalibration, FloorPoint
from robsim.lab.calibration.grid import mark_middles, single_marks
from robsim.lab.calibration.lens import checked_names, images_of
from robsim.lab.calibration.patterns.floor_sheet import MOST_SHEETS, find_sheets
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.calibration import Calibration, Residuals
from robsim.vision.imaging.images import Pixels, frame_pixels, frame_size
from robsim.vision.robots.polygons import placed

_FEWEST = 4
_KNOWN = 6  # numbers more than parameters that determine the noise alone.
_NOISE = 0.5  # px, the noise that is assumed with fewer.
_MOST_SUSPECTS = 8  # marks that are left out on trial
_LEVEL = 1e-4  # at which one is called wrong
_LEAST_WRONG = 1.0  # px
_MOST_POINTS = 100_000


def calibrate_floor(
    pixels: ArrayLike,
    positions: ArrayLike,
    *,
    area: tuple[int, int],
    mm_per_px: float,
    marker_height: float = 0.0,
    lens: Calibration | None = None,
    size: tuple[int, int] | None = None,
    names: Sequence[str] | None = None,
    picture: Pixels | Frame | None = None,
) -> FloorCalibration:
    """Calibrate a camera's view of the floor by marks with measured positions.

    Parameters
    ----------
    pixels : array (N, 2)
        Pixels (u, v) of four or more marks, well spread over the area.
    positions : array (N, 2)
        Their positions on the floor (mm), from the top left corner of the work area. In the camera
        picture, x points right and y down.
    area : tuple of int
        Width and height of the work area (px).
    mm_per_px : float
        Size of a work-area pixel on the floor (mm).
    marker_height : float
        Height of the robot's markers above the floor (mm); requires a lens.
    lens : Calibration, optional
        The result of `calibrate_lens`. Default: the lens does not distort.
    size : tuple of int, optional
        Width and height of the frames (px). Default: the frame size of `picture` or `lens`.
    names : sequence of str, optional
        Names of the marks; marks with the same name are averaged. Default: their numbers, from 1.
    picture : Frame or array (H, W, 3) of uint8, optional
        An RGB picture of the floor. The floor sheets in the picture are stored for `sheet_shifts`.

    Returns
    -------
    FloorCalibration
        The calibration, and the fit of each mark. With six or more marks (five with a lens), a mark
        with a far worse fit than the others is omitted, and the report names this mark.

    Raises
    ------
    ImportError
        If a picture is given, and OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type or shape, or too many marks lie on a line. Also if their
        order belongs to a mirrored floor.

    Examples
    --------
    >>> pixels = [(102, 80), (541, 77), (630, 455), (12, 460), (320, 200)]
    >>> positions = [(0, 0), (1199, 0), (1199, 1199), (0, 1199), (598, 431)]
    >>> found = robsim.lab.calibrate_floor(
    ...     pixels, positions, area=(1200, 1200), mm_per_px=1.0, size=(640, 480)
    ... )
    >>> found.verdict
    'bad'
    """
    area = check_size("area", area)
    scale = check_mm_per_px(mm_per_px)
    seen, places, called = _marks(pixels, positions, checked_names(names))
    image = None if picture is None else frame_pixels("picture", picture)
    if image is not None:
        found = frame_size(image)
        if size is not None and check_size("size", size) != found:
            raise ValueError(f"size must be {found}, the size of picture, got {quoted(size)}")
        size = found
    lens, size = _lens_and_size(lens, size)
    height = check_float("marker_height", marker_height, "mm", minimum=0)
    matrix = None if lens.intrinsics is None else np.asarray(lens.intrinsics.matrix)
    ideal = _ideal(lens, seen)
    _refuse_mirrored(ideal, places)
    wrong = None
    fit = fit_plane([ideal], [places], matrix)
    if fit.free >= TELLING:
        wrong, fit = _without_wrong(ideal, places, matrix, fit)
    marks = {} if image is None else single_marks(image)
    calibration = _calibration(lens, fit.to_floor, area, scale, height, marks)
    points = _points(calibration, called, seen, places, {wrong})
    return _report(calibration, fit, points)


def calibrate_floor_by_sheets(
    pictures: Iterable[Pixels | Frame],
    *,
    area: tuple[int, int],
    mm_per_px: float,
    marker_height: float = 0.0,
    lens: Calibration | None = None,
    mark: float = 80.0,
    places: Mapping[int, tuple[float, float]] | None = None,
) -> FloorCalibration:
    """Calibrate a camera's view of the floor by printed sheets on the floor.

    The sheets may have any positions and angles; spread them over the whole area if possible.
    The results of several pictures of the same floor are averaged.

    Parameters
    ----------
    pictures : iterable of Frame or array (H, W, 3) of uint8
        RGB pictures of the floor, from a stationary camera.
    area, mm_per_px, marker_height, lens
        As for `calibrate_floor`.
    mark : float
        Side of a mark on the sheets, measured on the print (mm).
    places : mapping of int to tuple of float, optional
        Position of a sheet's cross from the top left corner of the work area (mm), by number.
        Two or more positions determine the area's axes; with a single position, the area has the
        axes of its sheet. By default, the sheet with the lowest number lies in the middle of the
        area, and has the area's axes.

    Returns
    -------
    FloorCalibration
        The calibration, and the fit of each sheet.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or the pictures have different sizes.
        If the pictures show no sheet, or not the sheets in `places`.

    Examples
    --------
    >>> picture = np.full((480, 640, 3), 200, np.uint8)  # 1 px per mm
    >>> sheet = robsim.lab.FloorSheet(number=3, mark=60)
    >>> for x, y, width, height in np.rint(sheet.rectangles).astype(int):
    ...     picture[176 + y : 176 + y + height, 221 + x : 221 + x + width] = 20
    >>> fit = robsim.lab.calibrate_floor_by_sheets([picture], area=(300, 300), mm_per_px=2, mark=60)
    >>> fit.calibration.plane_map.to_world((420, 240)).round()
    array([200., 150.])
    """
    mark = check_float("mark", mark, "mm", minimum=5, maximum=1000)
    check_size("area", area)
    check_mm_per_px(mm_per_px)
    check_float("marker_height", marker_height, "mm", minimum=0)
    check_kind("lens", lens, Calibration, or_none=True)
    checked_places(places)
    size, sheets, moved, count = _seen_sheets(pictures, mark)
    return calibrate_floor_by_corners(
        sheets,
        size,
        area=area,
        mm_per_px=mm_per_px,
        marker_height=marker_height,
        lens=lens,
        mark=mark,
        places=places,
        count=count,
        moved=moved,
    )


def calibrate_floor_by_corners(
    sheets: Mapping[int, Corners],
    size: tuple[int, int],
    *,
    area: tuple[int, int],
    mm_per_px: float,
    marker_height: float,
    lens: Calibration | None,
    mark: float,
    places: Mapping[int, tuple[float, float]] | None,
    count: int = 1,
    moved: float = 0.0,
) -> FloorCalibration:
    """Calibrate by the corners of found sheets, by sheet number.

    `size` is the size of the pictures (px), `count` their number, and `moved` the motion of a
    corner from picture to picture (px). For the rest, see `calibrate_floor_by_sheets`.
    """
    area = check_size("area", area)
    scale = check_mm_per_px(mm_per_px)
    height = check_float("marker_height", marker_height, "mm", minimum=0)
    where = checked_places(places)
    lens, size = _lens_and_size(lens, size)
    for number in where:
        if number not in sheets:
            raise ValueError(
                f"places must name visible sheets, got sheet {number}; the visible sheets are "
                f"{listed(map(str, sheets))}"
            )
    numbers = sorted(sheets, key=lambda number: (number not in where, number))
    if not where:
        where = {numbers[0]: (area[0] / 2 * scale, area[1] / 2 * scale)}
    matrix = None if lens.intrinsics is None else np.asarray(lens.intrinsics.matrix)
    groups = [sheets[number] for number in numbers]
    fit = fit_plane(
        [_ideal(lens, group.pixels) for group in groups],
        [group.positions for group in groups],
        matrix,
    )
    angle, shift, ratio = _axes(fit, numbers, where)
    turned = np.array(
        [(np.cos(angle), -np.sin(angle), shift[0]), (np.sin(angle), np.cos(angle), shift[1])]
    )
    to_floor = np.vstack([turned, (0, 0, 1)]) @ fit.to_floor
    calibration = _calibration(lens, to_floor, area, scale, height, mark_middles(sheets, mark))
    points: list[FloorPoint] = []
    for number, group, place in zip(numbers, groups, fit.places, strict=True):
        floor = placed(placed(group.positions, place), (*shift, angle))
        called = [f"sheet {number}"] * len(floor)
        points += _points(calibration, called, group.pixels, floor, set())
    centres = placed(fit.places[:, :2], (*shift, angle))
    off = {
        number: float(np.linalg.norm(centre - where[number]))
        for number, centre in zip(numbers, centres, strict=True)
        if number in where and len(where) > 1
    }
    return _report(
        calibration,
        fit,
        points,
        shift=(float(shift[0]), float(shift[1]), angle),
        count=count,
        places_off=off,
        print_scale=ratio,
        moved=moved,
    )


def _lens_and_size(lens: Any, size: tuple[int, int] | None) -> tuple[Calibration, tuple[int, int]]:
    """Return the lens for frames of this size; without a lens, an unknown lens."""
    check_kind("lens", lens, Calibration, or_none=True)
    if lens is None:
        if size is None:
            raise ValueError("size or picture must be given if lens is omitted")
        lens = Calibration(size=size)
    if size is not None:
        lens.check_frames(size)
    return lens, lens.size


def _marks(pixels: Any, positions: Any, names: Any) -> tuple[Floats, Floats, list[str]]:
    """Return pixels, positions and names of the marks; marks with the same name are averaged."""
    seen, places = as_float_array("pixels", pixels), as_float_array("positions", positions)
    for name, array in (("pixels", seen), ("positions", places)):
        if array.ndim != 2 or array.shape[1:] != (2,) or len(array) > _MOST_POINTS:
            raise ValueError(f"{name} must have the shape (N, 2), got {array.shape}")
        if not np.isfinite(array).all() or np.abs(array).max(initial=0) > 1e7:
            raise ValueError(f"{name} must be finite, and at most 1e7")
    if len(seen) != len(places):
        raise ValueError(f"positions and pixels differ in length: {len(places)} and {len(seen)}")
    called = [str(n + 1) for n in range(len(seen))] if names is None else list(names)
    if len(called) != len(seen):
        raise ValueError(
            f"names and pixels must have the same length, got {len(called)} and {len(seen)}"
        )
    groups = {name: [i for i, one in enumerate(called) if one == name] for name in called}
    if len(groups) < _FEWEST:
        raise ValueError(f"pixels must have at least {_FEWEST} marks, got {len(groups)}")
    for name, rows in groups.items():
        if np.ptp(places[rows], axis=0).any():
            raise ValueError(f"positions must be one per mark, got several for {quoted(name)}")
    return (
        np.array([seen[rows].mean(axis=0) for rows in groups.values()]),
        np.array([places[rows[0]] for rows in groups.values()]),
        list(groups),
    )


def _ideal(lens: Calibration, pixels: Floats) -> Floats:
    """Return the pixels of an ideal lens."""
    if lens.intrinsics is None:
        return pixels
    ideal: Floats = np.asarray(lens.intrinsics.ideal(pixels))
    if not np.isfinite(ideal).all():
        raise ValueError("pixels must be inside the image of the lens")
    return ideal


def _without_wrong(
    ideal: Floats, places: Floats, matrix: Floats | None, fit: PlaneFit
) -> tuple[int | None, PlaneFit]:
    """Return the mark that does not fit the others, if any, and the fit of the others."""
    fits = []
    suspects = np.argsort(fit.gains())[::-1][:_MOST_SUSPECTS].tolist()
    for index in suspects:
        kept = np.arange(len(ideal)) != index
        spread = np.linalg.svd(places[kept] - places[kept].mean(axis=0), compute_uv=False)
        # with a lens, three on a line do no harm
        about = fit.to_floor if matrix is not None and spread[1] > 0.1 * spread[0] else None
        try:
            fits.append(fit_plane([ideal[kept]], [places[kept]], matrix, about))
        except ValueError:  # the others lie on a line
            fits.append(fit)
    first = int(np.argmin([one.squares for one in fits]))
    best, without = suspects[first], fits[first]
    if without is fit or without.free < 1:
        return None, fit
    # F = ((SSE - SSE') / 2) / (SSE' / n'), of a mark that is right F(2, n'), whose tail is
    # P(F > f) = (1 + 2 f / n')^(-n' / 2)
    assumed = max(_KNOWN - without.free, 0)
    free = without.free + assumed
    noise = max((without.squares + assumed * _NOISE**2) / free, 0.05**2)
    ratio = (fit.squares - without.squares) / 2 / noise
    is_wrong = (1 + 2 * ratio / free) ** (-free / 2) < _LEVEL / len(ideal)
    is_large = np.sqrt((fit.residuals[0] ** 2).sum(axis=1).max()) > _LEAST_WRONG
    return (best, without) if is_wrong and is_large else (None, fit)


def _calibration(
    lens: Calibration,
    to_floor: Floats,
    area: tuple[int, int],
    scale: float,
    marker_height: float,
    marks: Mapping[int, tuple[float, float]],
) -> Calibration:
    """Return the calibration, still without residuals."""
    return Calibration(
        size=lens.size,
        region=lens.region,
        intrinsics=lens.intrinsics,
        floor=PlaneMap(np.diag([1 / scale, 1 / scale, 1]) @ to_floor),
        area=area,
        mm_per_px=scale,
        marker_height=marker_height,
        lens_residuals=lens.lens_residuals,
        date=datetime.datetime.now(datetime.UTC).replace(microsecond=0),
        features=lens.features,
        marks=marks,
    )


def _points(
    calibration: Calibration,
    names: Sequence[str],
    pixels: Floats,
    places: Floats,
    wrong: set[int | None],
) -> list[FloorPoint]:
    floor, scale = calibration.floor, calibration.mm_per_px
    assert floor is not None
    assert scale is not None
    on_floor = np.linalg.norm(scale * floor.to_world(pixels) - places, axis=1)
    in_picture = np.linalg.norm(floor.to_pixel(places / scale) - pixels, axis=1)
    return [
        FloorPoint(name, tuple(pixel), tuple(place), float(mm), float(px), index not in wrong)
        for index, (name, pixel, place, mm, px) in enumerate(
            zip(names, pixels.tolist(), places.tolist(), on_floor, in_picture, strict=True)
        )
    ]


def _report(
    calibration: Calibration,
    fit: PlaneFit,
    points: list[FloorPoint],
    *,
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    count: int = 1,
    **others: Any,
) -> FloorCalibration:
    """Return the report, which contains the calibration with its residuals."""
    used = np.array([one.px for one in points if one.is_used])
    residuals = Residuals(
        rms=float(np.sqrt((used**2).mean())),
        worst=float(used.max()),
        points=len(used),
        pictures=count,
    )
    width, height = np.array(calibration.area) * calibration.mm_per_px
    corners = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    x, y, angle = shift  # back to the axes of the fit
    there = placed(corners - (x, y), (0.0, 0.0, -angle))
    return FloorCalibration(
        calibration=dataclasses.replace(calibration, floor_residuals=residuals),
        points=tuple(points),
        expected_errors=fit.expected_errors(there) if fit.free > 0 else np.full(4, np.nan),
        **others,
    )


def _refuse_mirrored(pixels: Floats, places: Floats) -> None:
    """Raise ValueError if x, y on the floor are mirrored in the picture."""
    middle = pixels.mean(axis=0)
    # places = A (pixels - middle) + b, but for perspective
    known = np.column_stack([pixels - middle, np.ones(len(pixels))])
    about, *_ = np.linalg.lstsq(known, places, rcond=None)
    if np.linalg.det(about[:2]) < 0:
        raise ValueError(
            "positions must have x to the right and y down, as in the picture, got a mirrored "
            "floor: check the direction of y, and the order of positions and pixels"
        )


def _seen_sheets(
    pictures: Iterable[Any], mark: float
) -> tuple[tuple[int, int], dict[int, Corners], float, int]:
    """Return size, corners of each sheet averaged over the pictures, their motion, the number."""
    size, count = (0, 0), 0
    pixels: dict[tuple[int, float, float], list[Floats]] = {}
    for image in images_of(pictures):
        size, count = frame_size(image), count + 1
        found = find_sheets(image, mark)
        for number, corners in found.items():
            for (x, y), pixel in zip(corners.positions.tolist(), corners.pixels, strict=True):
                pixels.setdefault((number, x, y), []).append(pixel)
    if not pixels:
        raise ValueError(
            "pictures must show a floor sheet (robsim calibrate sheet --kind floor), got none in "
            f"{count}: the marks of a sheet must be at least 15 px wide, sharp and visible"
        )
    moved = max(float(np.ptp(np.array(seen), axis=0).max()) for seen in pixels.values())
    sheets = {}
    for number in sorted({number for number, _, _ in pixels}):
        keys = [key for key in pixels if key[0] == number]
        sheets[number] = Corners(
            np.array([key[1:] for key in keys]),
            np.array([np.mean(pixels[key], axis=0) for key in keys]),
        )
    return size, sheets, moved, count


def checked_places(places: Any) -> dict[int, tuple[float, float]]:
    """Return positions of sheets by their numbers (mm); may be empty."""
    if places is None:
        return {}
    if not isinstance(places, Mapping):
        raise TypeError(f"places must be a mapping of numbers to (x, y), got {quoted(places)}")
    checked = {}
    for number, place in places.items():
        sheet = check_int("places", number, minimum=1, maximum=MOST_SHEETS)
        where = as_float_array(f"places[{quoted(number)}]", place)
        if where.shape != (2,) or not np.isfinite(where).all():
            raise ValueError(f"places[{quoted(number)}] must be (x, y) in mm, got {quoted(place)}")
        checked[sheet] = (float(where[0]), float(where[1]))
    return checked


def _axes(
    fit: PlaneFit, numbers: Sequence[int], where: Mapping[int, tuple[float, float]]
) -> tuple[float, Floats, float]:
    """Return angle and shift from the axes of the fit to the area's, and the remaining scale."""
    rows = [numbers.index(number) for number in where]
    targets = np.array(list(where.values()))
    if len(rows) > 1:
        return aligned(fit.places[rows, :2], targets)
    return 0.0, targets[0] - fit.places[rows[0], :2], 1.0
