"""The measurements of a camera's frames, one by one, for judging the camera."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from robsim._core import (
    Blob,
    ColorClass,
    Detection,
    Frame,
    MarkerLayout,
    detect,
    find_blobs,
    frame_noise,
    rgb_to_yuv,
)
from robsim.base.checks import Floats
from robsim.lab.rehearsal._calibration_findings import MarkerPair, marker_pair
from robsim.vision.markers.training import margin_of
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.polygons import area_and_centroid, placed

_INNER = 0.7  # of a marker's outline, from its centre: the edge mixes with its surroundings
_OUTER = 1.2  # all of it
_AROUND = 1.6
_CLIPPED = 254  # levels
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class MarkerLight:
    """The pixels of a marker in a frame."""

    level: float  # The brightest channel of its mean colour (0..255).
    clipped: float  # Share of its pixels with a channel at the upper end.
    # By how much its mean colour is inside the limits of its class (levels); negative outside.
    margin: float
    # Distance in (U, V) between its mean colour and its surroundings' (levels).
    contrast: float
    found: float  # Area of its blob, as a fraction of the marker's


def marker_light(
    frame: Frame, corners: Floats, blob: Blob, color: ColorClass
) -> MarkerLight | None:
    """Return a marker's light, from corners (N, 2) in frame px; None if too little is in view."""
    if not np.isfinite(corners).all():  # outside of the lens's image
        return None
    centre = corners.mean(axis=0)
    reach = _AROUND * np.abs(corners - centre).max(axis=0) + 1
    height, width = frame.image.shape[:2]
    left, top = np.maximum(np.floor(centre - reach), 0).astype(int)
    right, bottom = np.minimum(np.ceil(centre + reach), (width - 1, height - 1)).astype(int)
    if right - left < 2 or bottom - top < 2:
        return None
    rgb = np.ascontiguousarray(frame.image[top : bottom + 1, left : right + 1])
    polygons = (centre + scale * (corners - centre) - (left, top) for scale in (_INNER, _OUTER))
    inner, outer = (_mask(polygon, rgb.shape[:2]) for polygon in polygons)
    if inner.sum() < 4 or outer.all():
        return None
    yuv = rgb_to_yuv(rgb).astype(float)
    color_of_marker, color_around = yuv[inner].mean(axis=0), yuv[~outer].mean(axis=0)
    return MarkerLight(
        level=float(rgb[inner].mean(axis=0).max()),
        clipped=float((rgb[inner].max(axis=1) >= _CLIPPED).mean()),
        margin=margin_of(color, color_of_marker),
        contrast=float(np.hypot(*(color_of_marker - color_around)[1:])),
        found=blob.area / area_and_centroid(corners)[0],
    )


def _mask(polygon: Floats, shape: tuple[int, ...]) -> Mask:
    drawn = Image.new("1", (shape[1], shape[0]))
    ImageDraw.Draw(drawn).polygon([(float(x), float(y)) for x, y in polygon], fill=1)
    return np.array(drawn)


_KEPT = 3  # frames, to look for floor sheets in when all have come
_WHITE_LEVEL, _BLACK_LEVEL = 250, 3
_GRID = 96  # pixels that are looked at for the light of the whole frame, in each direction


class CameraLook:
    """The view of a robot with markers of these colours in a camera's frames, one by one."""

    def __init__(
        self, robot: RobotDefinition, colors: Sequence[ColorClass], smoothing: int | None
    ) -> None:
        self.markers: MarkerLayout = robot.marker_layout()
        self._corners = {
            marker.color: robot.to_robot_frame(marker.polygon) for marker in robot.markers.values()
        }
        self._colors = {color.name: color for color in colors}
        self._smoothing = smoothing
        self.detections: list[Detection] = []
        self.times: list[tuple[int, float, float]] = []  # number, exposure, arrival (s)
        self.last: deque[Frame] = deque(maxlen=_KEPT)
        self.poses: list[Floats] = []
        self.others: list[int] = []
        self.light: list[tuple[float, float, float]] = []  # mean, shares of white and of black
        self.noise: list[float] = []  # standard deviation of a channel (grey levels)
        self.signal_to_noise: list[float] = []  # of the markers, where the robot was detected
        self.pairs: list[MarkerPair] = []
        self.marker_light: dict[str, list[MarkerLight]] = {name: [] for name in self._corners}

    @property
    def seen(self) -> int:
        """Number of frames in which the robot was detected."""
        return len(self.poses)

    def at(self, frame: Frame) -> None:
        colors = [*self._colors.values()]
        blobs = find_blobs(frame, colors, markers=self.markers, smoothing=self._smoothing)
        detection = detect(
            blobs, self.markers, plane_map=frame.plane_map, image=frame, colors=colors
        )
        self.detections.append(detection)
        self.last.append(frame)
        self.times.append((frame.index, frame.t or 0.0, frame.t_arrival or frame.t or 0.0))
        self.light.append(_light_of(frame))
        self.noise.append(frame_noise(frame))
        self.others.append(self._others(blobs, detection))
        if pair := marker_pair(frame, blobs, detection, self.markers):
            self.pairs.append(pair)
        if detection.measurement is not None or not self.seen:
            self.shown = frame, blobs, detection
        if detection.measurement is None:
            return
        pose = detection.measurement.pose
        self.poses.append(pose)
        if detection.measurement.signal_to_noise is not None:
            self.signal_to_noise.append(detection.measurement.signal_to_noise)
        for name, blob in self._found(detection).items():
            corners = frame.plane_map.to_pixel(placed(self._corners[name], pose))
            if light := marker_light(frame, corners, blob, self._colors[name]):
                self.marker_light[name].append(light)

    def _found(self, detection: Detection) -> dict[str, Blob]:
        """Return the blobs of a detected robot, by colour."""
        assert detection.seen is not None
        return {blob.color: blob for blob in detection.seen.values()}

    def _others(self, blobs: Mapping[str, Sequence[Blob]], detection: Detection) -> int:
        """Return the number of further blobs as large as markers."""
        if detection.measurement is None:
            return 0
        found = self._found(detection)
        tolerance = self.markers.area_tolerance
        return sum(
            1 / tolerance < blob.area / found[name].area < tolerance
            for name in found
            for blob in blobs.get(name, ())
            if blob != found[name]
        )


def _light_of(frame: Frame) -> tuple[float, float, float]:
    height, width = frame.image.shape[:2]
    some = frame.image[:: max(1, height // _GRID), :: max(1, width // _GRID)]
    white = (some.min(axis=2) >= _WHITE_LEVEL).mean()
    black = (some.max(axis=2) <= _BLACK_LEVEL).mean()
    return float(some.mean()), float(white), float(black)
