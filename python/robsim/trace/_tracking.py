"""How well the measurement followed the truth: what `Trace.tracking` returns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim._base.report import Quantity, Report, count
from robsim.trace._run_info import RunInfo
from robsim.trace._units import length_format

#: Farther from the truth than this, a measured pose is a false one (px, rad).
FALSE_POSE_LIMITS = (10.0, np.deg2rad(20.0))


@dataclass(frozen=True, kw_only=True)
class TrackingStatistics(Report):
    """How well the measurement followed the truth.

    Attributes
    ----------
    steps : int
        Steps of the record.
    seen : int
        Steps in which the robot was found.
    false_poses : int
        Steps seen with a pose more than 10 px or 20 degrees off.
    rmse_xy : float
        sqrt(mean(dx^2 + dy^2)) over the poses that are not false (in `unit`); NaN if there are
        none, or the truth is not known.
    rmse_heading_deg : float
        Root mean square of the heading error over the poses that are not false (degrees).
    median_xy : float
        Median of sqrt(dx^2 + dy^2) over all steps seen, false poses included (in `unit`); NaN if
        the truth is not known.
    median_heading_deg : float
        Median of the absolute heading error over all steps seen (degrees).
    largest_xy : float
        Largest sqrt(dx^2 + dy^2) of the poses that are not false (in `unit`).
    largest_heading_deg : float
        Largest absolute heading error of the poses that are not false (degrees).
    unit : str
        The unit of lengths: ``"px"`` of the work area, or that of `Trace.in_unit`.
    position_limit : float
        Farther from the truth than this, a pose is false: 10 px (in `unit`).
    """

    steps: int
    seen: int
    false_poses: int
    rmse_xy: float
    rmse_heading_deg: float
    median_xy: float
    median_heading_deg: float
    largest_xy: float
    largest_heading_deg: float
    unit: str = "px"
    position_limit: float = FALSE_POSE_LIMITS[0]

    @property
    def title(self) -> str:
        """What was tracked."""
        return "Tracking" if self.seen else "Tracking, never seen"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Steps seen, false poses, errors."""
        false_poses = None if self._is_truth_unknown else self.false_poses
        steps = (
            Quantity("steps", "steps", self.steps),
            Quantity("seen", "seen", self.seen, format=lambda n: count(n, self.steps)),
            Quantity("false_poses", "false poses", false_poses),
        )
        return (
            *steps,
            *self._pair("rmse", "rmse"),
            *self._pair("median", "median error"),
            *self._pair("largest", "largest error"),
        )

    def _pair(self, key: str, title: str) -> tuple[Quantity, Quantity]:
        """Return an error of the position and that of the heading."""
        xy, heading = f"{key}_xy", f"{key}_heading_deg"
        length = length_format(self.unit, 3)
        return (
            Quantity(xy, f"{title} of the position", getattr(self, xy), self.unit, length),
            Quantity(heading, f"{title} of the heading", getattr(self, heading), "deg", ".3f"),
        )

    @property
    def _is_truth_unknown(self) -> bool:
        return self.seen > 0 and math.isnan(self.median_xy)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Why there are no errors, or such large ones."""
        if self._is_truth_unknown:
            return ("the true poses are not known, so there are no errors",)
        if self.steps and not self.seen:
            return (
                "no pose was measured: the robot was detected in no frame, or it was run without "
                "measure=True; a measure of your own must return its Measurement",
            )
        if not self.false_poses:
            return ()
        remarks = [
            "rmse and largest error are those of the poses that are not false, the median of all"
        ]
        # The positions are right: it is the headings that make the poses false.
        if 2 * self.false_poses > self.seen and self.median_xy < self.position_limit:
            remarks.append(
                "the positions are right, the headings are not: is the heading of the Measurement "
                "in rad, and does it grow from +x towards +y?"
            )
        return tuple(remarks)


def tracking_statistics(
    error: Floats, seen: NDArray[np.bool_], is_false: NDArray[np.bool_], *, info: RunInfo
) -> TrackingStatistics:
    """Return the statistics of measured poses.

    Parameters
    ----------
    error : array (N, 3)
        Measured minus true poses (x, y in the unit of the trace, heading in rad).
    seen, is_false : array (N,) of bool
        Steps with a measured pose; those with a false one.
    info : RunInfo
        What concerns the run as a whole.
    """
    distance = np.hypot(error[:, 0], error[:, 1])
    turn = np.rad2deg(np.abs(error[:, 2]))
    good = seen & ~is_false
    return TrackingStatistics(
        steps=len(error),
        seen=int(seen.sum()),
        false_poses=int(is_false.sum()),
        rmse_xy=_rms(error[good, :2]),
        rmse_heading_deg=math.degrees(_rms(error[good, 2:])),
        median_xy=_median(distance[seen]),
        median_heading_deg=_median(turn[seen]),
        largest_xy=_largest(distance[good]),
        largest_heading_deg=_largest(turn[good]),
        unit=info.unit,
        position_limit=FALSE_POSE_LIMITS[0] * info.px_length,
    )


def _rms(rows: Floats) -> float:
    return math.sqrt(np.square(rows).sum(axis=1).mean()) if len(rows) else math.nan


def _median(values: Floats) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _largest(values: Floats) -> float:
    return float(values.max()) if len(values) else math.nan
