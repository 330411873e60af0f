"""Forgets that the work area begins half a pixel before the first pixel's centre."""

import numpy as np
from task import AREA, MARKER_DISTANCE, MARKER_OFFSET

import robsim

SMALLEST = 25  # px of the frame: specks of noise are smaller, the markers twice as large


def measure(step):
    scale = AREA[0] / step.frame.image.shape[1]
    red, blue = (centroids(step.blobs[color], scale) for color in ("red", "blue"))
    if not len(red) or not len(blue):
        return None
    misfit = abs(np.linalg.norm(red[:, None] - blue, axis=2) - MARKER_DISTANCE)
    i, j = np.unravel_index(misfit.argmin(), misfit.shape)
    return pose_of(red[i], blue[j]) if misfit[i, j] < 0.25 * MARKER_DISTANCE else None


def centroids(blobs, scale):
    return np.array([scale * np.array(blob.centroid) for blob in blobs if blob.area >= SMALLEST])


def pose_of(right, left):
    # the robot's centre lies ahead of the middle of its markers
    across = (right - left) / np.linalg.norm(right - left)
    forward = np.array([across[1], -across[0]])
    x, y = (right + left) / 2 + MARKER_OFFSET * forward
    return robsim.Measurement((x, y, np.arctan2(forward[1], forward[0])))
