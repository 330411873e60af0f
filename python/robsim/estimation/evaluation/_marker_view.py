"""The pixels of a marker in a frame: how deep in it they lie, and what they tell of its pose."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from robsim._core import Frame
from robsim.base.checks import Floats
from robsim.base.geometry.polygons import depths, samples
from robsim.base.text import quoted

# Frame px: how far outside of a marker pixels are used, and by how much a marker is moved to see
# how the depths of its pixels change.
_MARGIN = 2.5
_STEP = 0.02


class MarkerView:
    """The pixels of a marker in a frame, and how deep in it they lie."""

    def __init__(self, frame: Frame, pose: Floats, polygon: Floats) -> None:
        self._plane_map = frame.plane_map
        self._outline = samples(polygon)  # dense: a lens may bend its sides
        corners = self._in_frame(pose)
        height, width = frame.image.shape[:2]
        left, top = np.floor(corners.min(axis=0) - _MARGIN).clip(0, (width, height)).astype(int)
        right, bottom = np.ceil(corners.max(axis=0) + _MARGIN).clip(0, (width, height)).astype(int)
        down, across = np.mgrid[top:bottom, left:right]
        self._pixels = np.column_stack((across.ravel(), down.ravel())).astype(float)
        depth = depths(corners, self._pixels)
        is_used = depth > -_MARGIN
        if depth.max(initial=-1.0) <= 0:
            raise _not_shown(pose)
        self._pixels, self.depth = self._pixels[is_used], depth[is_used]
        self.values = frame.image[down.ravel()[is_used], across.ravel()[is_used]].astype(float)
        self._slopes = self._slopes_at(pose)

    def _in_frame(self, pose: Floats) -> Floats:
        """Return the outline at a pose in px of the frame (N, 2)."""
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        # position = centre + R(heading) (forward, right)
        positions = self._outline @ np.array(((cos, sin), (-sin, cos))) + pose[:2]
        pixels = self._plane_map.to_pixel(positions)
        if not np.isfinite(pixels).all():
            raise _not_shown(pose)
        return np.asarray(pixels)

    def _slopes_at(self, pose: Floats) -> Floats:
        """Return the derivatives of the depths by the pose (N, 3)."""
        # One step moves the marker by about _STEP px of the frame.
        across = np.ptp(self._outline, axis=0).max() / np.ptp(self._in_frame(pose), axis=0).max()
        far = np.linalg.norm(self._outline, axis=1).max()
        slopes = np.empty((len(self.depth), 3))
        for i, step in enumerate(_STEP * across * np.array((1.0, 1.0, 1.0 / far))):
            moved = np.eye(3)[i] * step
            ahead, behind = (
                depths(self._in_frame(pose + sign * moved), self._pixels) for sign in (1, -1)
            )
            slopes[:, i] = (ahead - behind) / (2 * step)
        return slopes

    def coverage(self, width: float) -> Floats:
        """Return 1 and the coverage Phi(d / w) of each pixel (N, 2)."""
        from scipy.special import ndtr

        covered = ndtr(self.depth / width)
        return np.column_stack((np.ones_like(covered), covered))

    def levels(self, width: float) -> Floats:
        """Return level and contrast of each channel (2, 3), by least squares."""
        return np.asarray(np.linalg.lstsq(self.coverage(width), self.values, rcond=None)[0])

    def misfit(self, width: float) -> float:
        """Return the sum of the squared residuals."""
        residuals = self.values - self.coverage(width) @ self.levels(width)
        return float(np.square(residuals).sum())

    def channels(self, width: float) -> Iterator[tuple[Floats, Floats, float]]:
        """Yield mean (N,), its derivatives by pose and ln w (N, 4), and contrast of a channel."""
        q = self.depth / width
        # d Phi(d / w) = phi(q) (d depth / w - q d ln w)
        change = density(q)[:, np.newaxis] * np.column_stack((self._slopes / width, -q))
        for level, contrast in self.levels(width).T:
            mean = level + contrast * self.coverage(width)[:, 1]
            yield mean, contrast * change, float(contrast)


def _not_shown(pose: Floats) -> ValueError:
    return ValueError(f"pose must show the markers in the frame, got {quoted(pose.tolist())}")


def density(q: Floats) -> Floats:
    """Return the density of the standard normal distribution."""
    density: Floats = np.exp(-0.5 * np.square(q)) / math.sqrt(2 * math.pi)
    return density
