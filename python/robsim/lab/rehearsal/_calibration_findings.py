"""Whether the map from pixels to the floor fits the robot in the frames."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import Blob, Detection, Frame, MarkerLayout
from robsim.base.checks import Floats
from robsim.lab.calibration.grid import sheet_shifts
from robsim.vision.imaging.calibration import Calibration

_GRID = 12  # points along each side of the area
_APART = 0.15  # of the area's longer side: the robot was in several places
_FEWEST = 12  # frames
_PARTS = 4  # of the frames, by place
_STEPS = 40  # of a bisection
_TALLEST = 300.0  # mm, of a robot on such a floor


@dataclass(frozen=True)
class MarkerPair:
    """The positions of both markers in a frame."""

    pixels: Floats  # (2, 2): (u, v) of both, in the order of their roles
    middle: Floats  # (2,): their middle on the work area (px)
    ratio: float  # of their distance on the work area to the one of the robot's definition


def marker_pair(
    frame: Frame, blobs: Mapping[str, Sequence[Blob]], detection: Detection, markers: MarkerLayout
) -> MarkerPair | None:
    """Return the marker positions, even too far apart: then from the largest blobs."""
    found = []
    for role, name in markers.colors.items():
        largest = max(blobs.get(name, ()), key=lambda blob: blob.area, default=None)
        blob = detection.seen[role] if detection.seen else largest
        if blob is None:
            return None
        found.append(blob.centroid)
    pixels = np.array(found)
    placed = frame.plane_map.to_world(pixels)
    distance = float(np.linalg.norm(placed[0] - placed[1]))
    if not math.isfinite(distance):
        return None
    return MarkerPair(pixels, placed.mean(axis=0), distance / markers.distance)


def median_excess(pairs: Sequence[MarkerPair]) -> float:
    """Return the relative excess of the markers' distance; NaN = markers not seen."""
    return float(np.median([one.ratio for one in pairs])) - 1 if pairs else math.nan


def spread_over_places(pairs: Sequence[MarkerPair], area: tuple[int, int]) -> float:
    """Return the relative variation of the markers' distance over places; NaN = one place."""
    if len(pairs) < _FEWEST:
        return math.nan
    middles = np.array([one.middle for one in pairs])
    centred = middles - middles.mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    if np.ptp(along) < _APART * max(area):
        return math.nan
    ratios = np.array([one.ratio for one in pairs])[np.argsort(along)]
    return float(np.ptp([np.median(part) for part in np.array_split(ratios, _PARTS)]))


def explaining_height(
    pairs: Sequence[MarkerPair], calibration: Calibration, distance: float
) -> float | None:
    """Return the marker height (mm) that explains the markers' distance.

    `distance` is in work-area px. None if no height explains it, or the camera's height is not
    known.
    """
    floor, scale = calibration.floor, calibration.mm_per_px
    if floor is None or calibration.intrinsics is None or scale is None or not pairs:
        return None
    pixels = np.concatenate([one.pixels for one in pairs])

    def ratio(height: float) -> float:
        there = (floor.at_height(height) if height else floor).to_world(pixels).reshape(-1, 2, 2)
        return float(np.median(np.linalg.norm(there[:, 0] - there[:, 1], axis=1))) / distance

    # Higher points are closer to the camera, and look larger: the ratio falls as 1 - h / H.
    on_floor = ratio(0.0)
    if on_floor <= 1:
        return None
    low, high = 0.0, 1.0
    try:
        while ratio(high) > 1:
            low, high = high, 2 * high
        for _ in range(_STEPS):
            middle = (low + high) / 2
            low, high = (middle, high) if ratio(middle) > 1 else (low, middle)
    except ValueError:  # above the camera
        return None
    return scale * high


def visible_share(calibration: Calibration) -> float:
    """Return the share of the work area that the frames show."""
    width, height = calibration.area or (1, 1)
    grid = np.meshgrid(np.linspace(0, width - 1, _GRID), np.linspace(0, height - 1, _GRID))
    pixels = calibration.plane_map.to_pixel(np.stack(grid, axis=-1).reshape(-1, 2))
    size = np.array(calibration.size)
    is_inside = ((pixels >= -0.5) & (pixels <= size - 0.5)).all(axis=1)  # NaN is not
    return float(is_inside.mean())


def shifts_of_sheets(frames: Iterable[Frame], calibration: Calibration) -> dict[int, float]:
    """Return each sheet's shift from its place (px, median); empty without sheets or OpenCV."""
    each: dict[int, list[float]] = {}
    try:
        for frame in frames:
            for sheet, shift in sheet_shifts(frame, calibration).items():
                each.setdefault(sheet, []).append(shift)
    except ImportError:
        return {}
    return {sheet: float(np.median(shifts)) for sheet, shifts in each.items()}


def remedy(
    excess: float, pairs: Sequence[MarkerPair], calibration: Calibration | None, distance: float
) -> str:
    """Return the likely cause of markers that seem too far apart or too close."""
    how = "farther apart" if excess > 0 else "closer together"
    said = f"the markers seem {100 * abs(excess):.0f} % {how} than in the robot's definition: "
    if calibration is None:
        return (
            said + "is the work area's size right, and does the camera look straight down? "
            "Otherwise calibrate it (robsim calibrate)"
        )
    height = explaining_height(pairs, calibration, distance)
    given = calibration.marker_height
    if height is not None and abs(height - given) > 1 and height <= _TALLEST:
        if not given:
            return (
                said + f"it is calibrated for markers on the floor, and {height:.0f} mm above it "
                "they would fit: is that their height? Then give --marker-height; or was the "
                "camera moved, or zoomed?"
            )
        return (
            said + f"it is calibrated for {given:g} mm above the floor, and at {height:.0f} mm "
            "they would fit: is the height right, or was the camera moved, or zoomed?"
        )
    return (
        said + "was the camera moved or zoomed since its calibration, or is --scale, --mark or the "
        "robot's size wrong?"
    )


def remedy_of_spread(calibration: Calibration | None) -> str:
    """Return the likely cause of a distance that differs from place to place."""
    if calibration is None:
        return (
            "the markers' distance differs from place to place: the camera looks obliquely, or its "
            "lens distorts; calibrate it (robsim calibrate)"
        )
    return (
        "the markers' distance differs from place to place: the camera was tilted or moved since "
        "its calibration; calibrate the floor again (robsim calibrate floor)"
    )
