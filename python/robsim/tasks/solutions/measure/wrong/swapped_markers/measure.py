"""Takes the left marker for the right one."""

import numpy as np
from task import MARKER_DISTANCE, MARKER_OFFSET

import robsim

SMALLEST = 25  # px of the frame: specks of noise are smaller, the markers twice as large


def measure(step):
    to_world = step.frame.plane_map.to_world
    blue, red = (centroids(step.blobs[color], to_world) for color in ("red", "blue"))
    if not len(red) or not len(blue):
        return None
    misfit = abs(np.linalg.norm(red[:, None] - blue, axis=2) - MARKER_DISTANCE)
    i, j = np.unravel_index(misfit.argmin(), misfit.shape)
    return pose_of(red[i], blue[j]) if misfit[i, j] < 0.25 * MARKER_DISTANCE else None


def centroids(blobs, to_world):
    return np.array([to_world(blob.centroid) for blob in blobs if blob.area >= SMALLEST])


def pose_of(right, left):
    # the robot's centre lies ahead of the middle of its markers
    across = (right - left) / np.linalg.norm(right - left)
    forward = np.array([across[1], -across[0]])
    x, y = (right + left) / 2 + MARKER_OFFSET * forward
    return robsim.Measurement((x, y, np.arctan2(forward[1], forward[0])))
