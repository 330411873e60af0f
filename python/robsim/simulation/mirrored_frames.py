"""Whether the frames of an `Experiment` are mirrored, or in the order BGR."""

from __future__ import annotations

import numpy as np

from robsim._core import Detection, Frame, detect
from robsim.base.checks import Floats
from robsim.simulation.runner import Runner
from robsim.vision.robots.marker_check import looks_mirrored

_MOST_LAG = 5  # steps from an input to the motion that shows it
_LEAST_PAIRS = 20
_LEAST_PATH = 50.0  # work-area px
_CLEAR = 0.6  # correlation; a robot of some inertia that follows its inputs has 0.75
_LEAD = 0.5  # of the correlation backwards over the one forwards


def mirrored_remark(runner: Runner) -> str | None:
    """Return a sentence if the frames of a run seem to be mirrored or BGR, or None."""
    step = runner.last_step
    if step.detection is None:
        return None

    def find(frame: Frame) -> Detection:
        return detect(runner.find_blobs(frame), runner.markers, image=frame)

    frame = step.frame
    if frame is not None and looks_mirrored(frame, runner.robot, find):
        return (
            f"the robot {runner.robot.name} is seen only with red and blue exchanged: the frames "
            "seem to be in OpenCV's order, BGR; make them with Frame.from_bgr. Or they are "
            "mirrored: "
            "then Frame(numpy.ascontiguousarray(image[:, ::-1]))"
        )
    if drives_backwards(runner.trace.u, runner.trace.pose_measured):
        return (
            "the robot was measured driving backwards while its inputs were forwards: are the "
            "frames in OpenCV's order, BGR (then make them with Frame.from_bgr), is the alignment "
            "of "
            "the robot half a turn off, or are its motors reversed?"
        )
    return None


def drives_backwards(u: Floats, poses: Floats) -> bool:
    """Return whether a robot clearly moves against inputs (N, 2), V, by its poses (N, 3).

    In 100 steps of `DriveAround` it found 88 % of 120 reversed robots, and reported none of 360
    correct ones (tests/statistics/RESULTS.md). NaN = not seen.
    """
    voltage = u.mean(axis=1)
    heading = poses[:-1, 2]
    moved = np.diff(poses[:, :2], axis=0)
    forward = moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading)
    if np.nansum(abs(forward)) < _LEAST_PATH:
        return False
    correlations = [
        _correlation(voltage[: len(forward) - lag], forward[lag:])
        for lag in range(min(_MOST_LAG + 1, len(forward)))
    ]
    backwards = -min(correlations)
    return backwards > _CLEAR and backwards > max(correlations) + _LEAD


def _correlation(a: Floats, b: Floats) -> float:
    """Return sum(a b) / sqrt(sum(a^2) sum(b^2)) where both are known; 0 if these are few."""
    is_known = np.isfinite(a) & np.isfinite(b)
    if is_known.sum() < _LEAST_PAIRS:
        return 0.0
    a, b = a[is_known], b[is_known]
    scale = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / scale) if scale > 0 else 0.0
