"""The pose by centroids of the same blobs: weighted by colour, and by OpenCV's moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from robsim._core import Blob, ColorClass, Detection, Frame, MarkerLayout, detect
from robsim.base.checks import Floats
from robsim.cli.simulated.bench import Found, opencv_finder, opencv_limits

_GROWN = 2  # px around a blob whose pixels count, too
_GREY = 128  # chroma without colour
_FOOT, _RISE = 0.2, 0.6  # of the median chroma of a blob: from where weights grow, and how far

Blobs = Mapping[str, Sequence[Blob]]


class BlobMethods:
    """Ways to measure a pose by the markers' blobs.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    colors : sequence of ColorClass
        Those of the markers.
    markers : MarkerLayout
        The markers.
    smoothing : int
        Width of the window that the blobs are classified with (px).
    """

    def __init__(
        self, cv2: Any, colors: Sequence[ColorClass], markers: MarkerLayout, smoothing: int
    ) -> None:
        self._cv2 = cv2
        self._markers = markers
        self._smoothing = smoothing
        self._colors = {color.name: color for color in colors}
        self._limits = {color.name: opencv_limits(color) for color in colors}

    def counted(self, frame: Frame, blobs: Blobs) -> Floats | None:
        """Return the pose by the blobs' own centroids, (3,); None if it is not found."""
        return _pose(self._detect(frame, blobs))

    def weighted(self, frame: Frame, blobs: Blobs) -> Floats | None:
        """Return the pose by centroids weighted by clipped chroma; None if it is not found."""
        found = self._detect(frame, blobs)
        if found.measurement is None:
            return None
        assert found.seen is not None
        weighted = (self._weighted(frame, blob) for blob in found.seen.values())
        return _pose(self._detect(frame, {blob.color: [blob] for blob in weighted}))

    def opencv(self, frame: Frame) -> Floats | None:
        """Return the pose by the moments of OpenCV's contours; None if it is not found."""
        find = opencv_finder(self._cv2, frame.image, [*self._colors.values()], self._smoothing)
        return _pose(self._detect(frame, _as_blobs(find())))

    def _detect(self, frame: Frame, blobs: Blobs) -> Detection:
        return detect(blobs, self._markers, plane_map=frame.plane_map)

    def _weighted(self, frame: Frame, blob: Blob) -> Blob:
        """Return a blob with its weighted centroid."""
        cv2, window = self._cv2, self._smoothing
        left, top, right, bottom = blob.bounding_box
        margin = _GROWN + window
        first_column, first_row = max(left - margin, 0), max(top - margin, 0)
        part = frame.image[first_row : bottom + margin + 1, first_column : right + margin + 1]
        smooth = cv2.blur(part, (window, window)) if window > 1 else part
        converted = cv2.cvtColor(smooth, cv2.COLOR_RGB2YCrCb)
        chroma = _chroma(converted, self._colors[blob.color])
        own = _largest_part(cv2, cv2.inRange(converted, *self._limits[blob.color]))
        if not own.any():
            return blob
        side = 2 * _GROWN + 1
        grown = cv2.dilate(own, np.ones((side, side), np.uint8)) > 0
        median = np.median(chroma[own > 0])
        # w = clip((C - .2 m)/(.6 m), 0, 1)
        weights = np.clip((chroma - _FOOT * median) / (_RISE * median), 0, 1) * grown
        rows, columns = np.indices(weights.shape)
        total = weights.sum()
        centroid = (
            first_column + (weights * columns).sum() / total,
            first_row + (weights * rows).sum() / total,
        )
        return Blob(blob.color, area=blob.area, centroid=centroid, bounding_box=blob.bounding_box)


def _pose(detection: Detection) -> Floats | None:
    return None if detection.measurement is None else detection.measurement.pose


def _chroma(converted: Any, color: ColorClass) -> Floats:
    """Return how far each pixel is from grey, in the channel in which the colour is."""
    # OpenCV's order: Y, Cr = V, Cb = U.
    ranges = {1: color.v, 2: color.u}
    channel = max(ranges, key=lambda one: abs(sum(ranges[one]) / 2 - _GREY))
    chroma: Floats = np.abs(converted[..., channel].astype(np.float64) - _GREY)
    return chroma


def _largest_part(cv2: Any, mask: Any) -> Any:
    """Return the largest connected part of a mask."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    if len(stats) < 2:
        return np.zeros_like(mask)
    return (labels == 1 + np.argmax(stats[1:, cv2.CC_STAT_AREA])).astype(np.uint8)


def _as_blobs(found: Found) -> dict[str, list[Blob]]:
    """Return areas and centroids as blobs."""
    return {
        name: [
            Blob(name, area=round(area), centroid=(u, v), bounding_box=_box(area, u, v))
            for area, u, v in sorted(rows.tolist(), reverse=True)
        ]
        for name, rows in found.items()
    }


def _box(area: float, u: float, v: float) -> tuple[int, int, int, int]:
    """Return a square of an area around a centroid (px)."""
    half = np.sqrt(area) / 2
    left, top, right, bottom = (round(x) for x in (u - half, v - half, u + half, v + half))
    return max(left, 0), max(top, 0), right, bottom
