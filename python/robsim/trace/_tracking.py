"""How well the measurement followed the truth: what `Trace.tracking` returns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

#: Farther from the truth than this, a measured pose is a false one (px, rad).
FALSE_POSE_LIMITS = (10.0, np.deg2rad(20.0))


@dataclass(frozen=True, kw_only=True)
class TrackingStatistics:
    """How well the measurement followed the truth.

    Attributes
    ----------
    steps : int
        Steps of the record.
    seen : int
        Steps in which the robot was found.
    false_poses : int
        Valid steps more than 10 px or 20 degrees off.
    rmse_xy : float
        sqrt(mean(dx^2 + dy^2)) over the steps seen (work-area px); NaN if the truth is not known.
    rmse_heading_deg : float
        Root mean square of the heading error over the steps seen (degrees).
    """

    steps: int
    seen: int
    false_poses: int
    rmse_xy: float
    rmse_heading_deg: float

    def __str__(self) -> str:
        if not self.seen:
            return f"tracking: {self.steps} steps, never seen"
        share = f"{100 * self.seen / self.steps:.1f} %"
        if math.isnan(self.rmse_xy):
            return f"tracking: {self.steps} steps, {self.seen} seen ({share})"
        return (
            f"tracking: {self.steps} steps, {self.seen} seen ({share}), {self.false_poses} false, "
            f"rmse {self.rmse_xy:.3f} px and {self.rmse_heading_deg:.3f} deg"
        )
