"""What is wrong at each step of a run, of a submission and of the reference beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import wrap_angle
from robsim.base.checks import Floats
from robsim.trace import Trace
from robsim.trace.units import length_format

#: What an error is of, which says its colour.
ESTIMATE, MEASUREMENT, DRIVE = "estimate", "measurement", "drive"

_POSES = {ESTIMATE: "pose_estimated", MEASUREMENT: "pose_measured"}


@dataclass(frozen=True)
class RunError:
    """An error of a submission and of the reference.

    Attributes
    ----------
    title, unit : str
        What it is, and its unit.
    of : str
        `ESTIMATE`, `MEASUREMENT` or `DRIVE`.
    yours : array (N,)
        That of the submission; NaN = not known.
    reference : array (M,) or None
        That of the reference.
    counts_at_end : bool
        Whether it should become small, and is large at first.
    unscored : int
        Number of rows at the start that do not count.
    """

    title: str
    unit: str
    of: str
    yours: Floats
    reference: Floats | None
    counts_at_end: bool = False
    unscored: int = 0

    @property
    def worst(self) -> int | None:
        """The row at which it is told: the last one, or that of the largest error."""
        known = np.flatnonzero(np.isfinite(self.yours))
        scored = known[known >= self.unscored]
        known = scored if len(scored) else known
        if not len(known):
            return None
        return int(known[-1]) if self.counts_at_end else int(known[self.yours[known].argmax()])

    def sentence(self, first_step: int) -> str:
        """Return how large it is, where, and that of the reference there."""
        at = self.worst
        if at is None:
            return f"{self.title}: not known at any step"
        when = "at the end" if self.counts_at_end else "at most"
        text = f"{self.title}: {when} {self._value(self.yours[at])}, in step {first_step + at}"
        theirs = self.reference
        if theirs is None or at >= len(theirs) or not np.isfinite(theirs[at]):
            return text
        return f"{text}, where the reference has {self._value(theirs[at])}"

    def _value(self, value: float) -> str:
        decimals = length_format(self.unit, 1) if self.unit in ("px", "mm", "cm", "m") else ".1f"
        return f"{format(value, decimals)} {self.unit}"


def run_errors(
    trace: Trace,
    reference: Trace | None,
    slots: Sequence[str],
    goals: Floats | None,
    unscored: int = 0,
) -> list[RunError]:
    """Return the errors of a run, by what the submission fills; see `draw_run`."""
    errors = _errors(trace, reference, slots, goals)
    return [replace(error, unscored=unscored) for error in errors]


def _errors(
    trace: Trace, reference: Trace | None, slots: Sequence[str], goals: Floats | None
) -> list[RunError]:
    if "estimate_state" in slots:
        return _of_poses(ESTIMATE, "estimated", trace, reference)
    if "measure" in slots:
        return _of_poses(MEASUREMENT, "measured", trace, reference)
    if {"init_parameter_estimator", "estimate_parameters"} & set(slots):
        theirs = None if reference is None else _relative_error(reference)
        title = "error of the parameters"
        return [RunError(title, "%", ESTIMATE, _relative_error(trace), theirs, counts_at_end=True)]
    return [] if goals is None else _of_drive(trace, reference, goals)


def _of_poses(of: str, word: str, trace: Trace, reference: Trace | None) -> list[RunError]:
    def errors(run: Trace) -> tuple[Floats, Floats]:
        poses: Floats = getattr(run, _POSES[of])
        off = poses - run.pose_true
        return np.hypot(off[:, 0], off[:, 1]), _degrees(off[:, 2])

    yours = errors(trace)
    theirs = (None, None) if reference is None else errors(reference)
    position, heading = f"error of the {word} position", f"error of the {word} heading"
    return [
        RunError(position, trace.info.unit, of, yours[0], theirs[0]),
        RunError(heading, "deg", of, yours[1], theirs[1]),
    ]


def _degrees(off: ArrayLike) -> Floats:
    turned: Floats = np.abs(np.rad2deg(wrap_angle(off)))
    return turned


def _relative_error(run: Trace) -> Floats:
    # 100 |theta - theta_true| / |theta_true| of each row of the model, and their mean
    true = np.asarray(run.info.theta_true, float)
    off = np.linalg.norm(run.parameters - true, axis=2) / np.linalg.norm(true, axis=1)
    relative: Floats = 100 * off.mean(axis=1)
    return relative


def _of_drive(trace: Trace, reference: Trace | None, goals: Floats) -> list[RunError]:
    is_goal = goals.ndim == 1

    def distances(run: Trace) -> Floats:
        return distance(run.pose_true[:, :2], goals)

    if not is_goal:  # the path begins where the robot stands
        goals = np.vstack((trace.pose_true[:1, :2], goals))
    theirs = None if reference is None else distances(reference)
    title = "distance from the goal" if is_goal else "distance from the path"
    unit = trace.info.unit
    errors = [RunError(title, unit, DRIVE, distances(trace), theirs, counts_at_end=is_goal)]
    if goals.shape == (3,):
        yours = _degrees(trace.pose_true[:, 2] - goals[2])
        theirs = None if reference is None else _degrees(reference.pose_true[:, 2] - goals[2])
        title = "heading, off that of the goal by"
        errors.append(RunError(title, "deg", DRIVE, yours, theirs, counts_at_end=True))
    return errors


def distance(positions: Floats, goals: Floats) -> Floats:
    """Return the distance of positions from a goal, or from a path of straight lines.

    Parameters
    ----------
    positions : array (N, 2)
        Positions.
    goals : array (2,), (3,) or (M, 2)
        A goal, or the corners of a path.
    """
    corners = np.atleast_2d(goals)[:, :2]
    if len(corners) == 1:
        corners = np.repeat(corners, 2, axis=0)
    starts, ways = corners[:-1], np.diff(corners, axis=0)
    off = positions[:, np.newaxis] - starts
    # The part of each line at which it is nearest, 0 to 1.
    part = (off * ways).sum(axis=2) / np.maximum((ways**2).sum(axis=1), 1e-12)
    nearest = starts + np.clip(part, 0, 1)[..., np.newaxis] * ways
    found: Floats = np.linalg.norm(positions[:, np.newaxis] - nearest, axis=2).min(axis=1)
    return found
