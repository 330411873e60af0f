"""Takes the largest blob of each colour for a marker, whatever else is red."""

import numpy as np
from task import MARKER_OFFSET

import robsim


def measure(step):
    if not step.blobs["red"] or not step.blobs["blue"]:
        return None
    to_world = step.frame.plane_map.to_world
    right = to_world(step.blobs["red"][0].centroid)
    left = to_world(step.blobs["blue"][0].centroid)
    across = (right - left) / np.linalg.norm(right - left)
    forward = np.array([across[1], -across[0]])
    x, y = (right + left) / 2 + MARKER_OFFSET * forward
    return robsim.Measurement((x, y, np.arctan2(forward[1], forward[0])))
