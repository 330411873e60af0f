"""Explains why vision found the robot in no step, for the commands ``run`` and ``track``."""

from __future__ import annotations

import numpy as np

from robsim._core import MarkerLayout
from robsim.trace import Trace


def explain_no_detection(trace: Trace, markers: MarkerLayout) -> str | None:
    """Return a sentence that explains why vision found the robot in no step.

    Parameters
    ----------
    trace : Trace
        The run.
    markers : MarkerLayout
        The markers that vision looked for.

    Returns
    -------
    str or None
        The sentence; None if the robot was found, or not looked for.
    """
    if trace.seen.any() or not {"red", "blue"} <= trace.blobs.keys():
        return None
    red, blue = trace.blobs["red"], trace.blobs["blue"]
    for name, centroids in (("red", red), ("blue", blue)):
        if not np.isfinite(centroids).any():
            return f"no {name} blob was detected: check the image and the colours"
    # distance of every red blob from every blue one, (N, 2, 2)
    distance = np.linalg.norm(red[:, :, np.newaxis] - blue[:, np.newaxis], axis=-1)
    if not np.isfinite(distance).any():
        return "red and blue blobs were not detected in the same frame"
    expected = markers.distance
    nearest = distance.flat[np.nanargmin(abs(distance - expected))]
    if abs(nearest - expected) <= markers.distance_tolerance * expected:
        return (
            f"red and blue blobs {nearest:.1f} px apart were detected, as the markers are, but "
            "their areas do not fit, other pairs fit as well, or they touch the border"
        )
    return (
        f"the markers are {expected:.1f} px apart, but the red and blue blobs detected "
        f"{nearest:.1f} px (of the work area): is it another robot, or another size of the area?"
    )
