"""Detection rate and accuracy of a run's measurement, from `Trace.tracking`."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Quantity, Report, count
from robsim.trace.run_info import RunInfo
from robsim.trace.units import length_format

#: #: A measured pose is false if it is farther from the truth than this (px, rad).
FALSE_POSE_LIMITS = (10.0, np.deg2rad(20.0))


@dataclass(frozen=True, kw_only=True)
class TrackingStatistics(Report):
    """Detection rate and accuracy of a run's measurement.

    Attributes
    ----------
    steps : int
        Steps of the record.
    seen : int
        Steps with a detected robot.
    false_poses : int
        Seen steps whose pose has an error above 10 px or 20 degrees.
    rmse_xy : float
        sqrt(mean(dx^2 + dy^2)) over the correct poses (in `unit`); NaN without correct poses, or if
        the truth is not known.
    rmse_heading_deg : float
        Root mean square of the heading error over the correct poses (degrees).
    median_xy : float
        Median of sqrt(dx^2 + dy^2) over all seen steps, with false poses (in `unit`); NaN if the
        truth is not known.
    median_heading_deg : float
        Median of the absolute heading error over all seen steps (degrees).
    largest_xy : float
        Largest sqrt(dx^2 + dy^2) of the correct poses (in `unit`).
    largest_heading_deg : float
        Largest absolute heading error of the correct poses (degrees).
    unit : str
        The unit of lengths: ``"px"`` of the work area, or from `Trace.in_unit`.
    position_limit : float
        A pose farther from the truth is false: 10 px (in `unit`).
    missed : dict of str to int
        Steps in which the default measurement did not see the robot, by reason, the most frequent
        first.
    reported_xy : float
        Median of the position's standard deviation reported by measurements, sqrt(P[0, 0] + P[1,
        1]) of their covariance P (in `unit`); NaN without reports.
    reported_heading_deg : float
        Median of the reported standard deviation of the heading (degrees).
    drawn_headings : int or None
        Number of drawn headings of the robot, if known.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True, dropout=robsim.Dropout(0.2, 3))
    >>> statistics = sim.run(100).tracking()
    >>> statistics.steps, statistics.seen, statistics.false_poses
    (100, 88, 0)
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
    missed: Mapping[str, int] = field(default_factory=dict)
    reported_xy: float = math.nan
    reported_heading_deg: float = math.nan
    drawn_headings: int | None = None

    @property
    def title(self) -> str:
        """The subject of the report: the tracking."""
        return "Tracking" if self.seen else "Tracking, never seen"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Steps seen and not seen, false poses, true errors and reported errors."""
        return (
            Quantity("steps", "steps", self.steps),
            Quantity("seen", "seen", self.seen, format=lambda n: count(n, self.steps)),
            *self._not_seen(),
            *self._errors(),
            *self._reported(),
        )

    def _not_seen(self) -> tuple[Quantity, ...]:
        """Return the steps not seen, with known reasons."""
        reasons = ", ".join(f"{reason} {steps}" for reason, steps in self.missed.items())
        text = f": {reasons}" if reasons else ""
        missed = self.steps - self.seen
        return (Quantity("not_seen", "not seen", missed, format=lambda n: f"{n}{text}"),)

    def _errors(self) -> tuple[Quantity, ...]:
        """Return the errors; the truth may be unknown."""
        false_poses = None if self._is_truth_unknown else self.false_poses
        return (
            Quantity("false_poses", "false poses", false_poses),
            *self._pair("rmse", "rmse"),
            *self._pair("median", "median error"),
            *self._pair("largest", "largest error"),
        )

    def _reported(self) -> tuple[Quantity, ...]:
        return () if math.isnan(self.reported_xy) else self._pair("reported", "reported error")

    def _pair(self, key: str, title: str) -> tuple[Quantity, Quantity]:
        """Return an error of the position and one of the heading."""
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
        """The reasons for missing or large errors, and the definitions of the terms."""
        if self.steps and not self.seen:
            if self.missed:
                return ("no pose was measured: the robot was detected in no frame",)
            return (
                "no pose was measured: run with measure=True; a measure of your own must return "
                "its Measurement",
            )
        return (*self._on_truth(), *self._on_false_poses(), *self._on_reports())

    def _on_truth(self) -> Iterator[str]:
        if self._is_truth_unknown:
            yield "the true poses are not known, so there are no errors"

    def _on_false_poses(self) -> Iterator[str]:
        if not self.false_poses or self._is_truth_unknown:
            return
        limit = format(self.position_limit, ".3g")
        yield (
            f"a pose more than {limit} {self.unit} or 20 deg off is false: rmse and largest error "
            "use only the other poses, the median uses all"
        )
        # The positions are right, so only the headings make the poses false.
        if 2 * self.false_poses > self.seen and self.median_xy < self.position_limit:
            yield (
                "the positions are right, but the headings are wrong: is the heading of the "
                "Measurement "
                "in rad, and does it grow from +x towards +y?"
            )

    def _on_reports(self) -> Iterator[str]:
        if not math.isnan(self.reported_xy):
            yield (
                "the reported error is the median standard deviation from the measurements. A "
                "correct "
                "one is as large as the rmse, and for the "
                "position, 1.2 times the median error; a larger rmse alone comes from a few poses"
            )
        if self.drawn_headings is not None and self.seen:
            turn = 360 / self.drawn_headings
            yield (
                f"the robot was drawn in {self.drawn_headings} headings, at whole pixels of the "
                f"frame: this rounding is an rmse of {turn / math.sqrt(12):.2g} deg and 0.4 px of "
                "the "
                "frame in each measurement; headings=None, in a terminal --headings continuous, "
                "draws the robot at its exact pose"
            )


def tracking_statistics(
    error: Floats,
    seen: NDArray[np.bool_],
    is_false: NDArray[np.bool_],
    *,
    reported: Floats,
    reasons: NDArray[np.str_],
    info: RunInfo,
) -> TrackingStatistics:
    """Return the statistics of measured poses.

    `error` (N, 3) is measured minus true (unit of the trace, rad), `reported` (N, 3, 3) are the
    covariances, NaN = missing. `seen`, `is_false` (N,): steps with a measured pose, with a false
    one; `reasons` (N,): why the robot was not seen.
    """
    distance = np.hypot(error[:, 0], error[:, 1])
    turn = np.rad2deg(np.abs(error[:, 2]))
    good = seen & ~is_false
    variances = np.diagonal(reported, axis1=1, axis2=2)
    variances = variances[seen & np.isfinite(variances).all(axis=1)]
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
        missed=dict(Counter(reasons[reasons != ""].tolist()).most_common()),
        reported_xy=_median(np.sqrt(variances[:, 0] + variances[:, 1])),
        reported_heading_deg=math.degrees(_median(np.sqrt(variances[:, 2]))),
        drawn_headings=info.headings,
    )


def _rms(rows: Floats) -> float:
    return math.sqrt(np.square(rows).sum(axis=1).mean()) if len(rows) else math.nan


def _median(values: Floats) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _largest(values: Floats) -> float:
    return float(values.max()) if len(values) else math.nan
