"""Why a robot was not seen."""

from __future__ import annotations

import numpy as np

from robsim._core import MarkerLayout
from robsim.trace import Trace


def explain_no_detection(trace: Trace, markers: MarkerLayout) -> str | None:
    """Return a sentence on why vision found the robot in no step.

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
    for name, places in (("red", red), ("blue", blue)):
        if not np.isfinite(places).any():
            return f"no {name} blob was seen: look at the image, and at the colours"
    # distance of every red blob from every blue one, (N, 2, 2)
    apart = np.linalg.norm(red[:, :, np.newaxis] - blue[:, np.newaxis], axis=-1)
    if not np.isfinite(apart).any():
        return "red and blue blobs were not seen in the same frame"
    expected = markers.distance
    nearest = apart.flat[np.nanargmin(abs(apart - expected))]
    if abs(nearest - expected) <= markers.distance_tolerance * expected:
        return (
            f"red and blue blobs {nearest:.1f} px apart were seen, as the markers are, but their "
            "sizes do not fit, others fit as well, or they touch the border"
        )
    return (
        f"the markers are {expected:.1f} px apart, but the red and blue blobs seen {nearest:.1f} "
        "px (of the work area): is it another robot, or the area another?"
    )
