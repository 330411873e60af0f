"""What the worst run of a measurement shows: its errors in the noise of the task."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.simulation.world.world_of_scenario import frame_size
from robsim.teach.doctor.callbacks.pose_mistakes import are_right, mistakes
from robsim.teach.doctor.tasks.seen_run import SeenRun, rms
from robsim.teach.tasks.trial import TaskTrial
from robsim.trace.trace import Bools

_LEAST = 5  # poses
_SEVERAL = 0.05  # of the frames
_WORSE = 1.3  # times the error of the reference
_BIASED = 0.5  # of the error


def measured_findings(trial: TaskTrial) -> Iterator[Problem]:
    """Yield what the worst run of a measurement shows, the cause first."""
    run = SeenRun.of(trial)
    if run is None:
        return
    trace = run.trace
    measured, true = trace.pose_measured, trace.pose_true
    hidden = trace.hidden.astype(bool)
    is_visible = trace.seen & ~hidden
    if is_visible.sum() >= _LEAST:
        scenario = run.task.scenario
        found = mistakes(
            measured[is_visible], true[is_visible], scenario._marker_layout, scenario.area
        )
        for kind, sentence in found:
            yield run.problem(kind, sentence)
    if (invented := trace.seen & hidden).sum() > _SEVERAL * len(trace):
        yield run.problem(
            "sees what is not there",
            f"it gives a pose in {invented.sum()} of the {hidden.sum()} frames in which the robot "
            "is hidden: return None there",
            k=int(invented.argmax()),
        )
    yield from _false(run, is_visible)
    is_right = np.zeros(len(trace), bool)
    is_right[is_visible] = are_right(measured[is_visible], true[is_visible])
    if is_right.sum() >= _LEAST:
        yield from _inexact(run, is_right)


def _false(run: SeenRun, is_visible: Bools) -> Iterator[Problem]:
    """Yield how often it takes something else for the robot, or does not find it."""
    trace, other = run.trace, run.reference
    false = trace.is_false & is_visible
    there = ~trace.hidden.astype(bool)
    lost, lost_there = (int((there & ~one.seen).sum()) for one in (trace, other))
    if false.sum() > _SEVERAL * len(trace):
        yield run.problem(
            "false poses",
            f"{false.sum()} of its {is_visible.sum()} poses are false, "
            f"{int((other.is_false).sum())} of the reference's: in noise there are other red and "
            "blue blobs; of all pairs take the one whose distance is that of the markers",
            k=int(false.argmax()),
        )
    if lost - lost_there > _SEVERAL * len(trace):
        yield run.problem(
            "not found",
            f"it does not find the robot in {lost} of the {there.sum()} frames in which it is to "
            f"be seen, the reference in {lost_there}",
            k=int((there & ~trace.seen).argmax()),
        )


def _inexact(run: SeenRun, is_right: Bools) -> Iterator[Problem]:
    """Yield why its poses are less exact than those of the reference."""
    measured, true = run.trace.pose_measured[is_right], run.trace.pose_true[is_right]
    off = measured[:, :2] - true[:, :2]
    others = run.reference.pose_measured - run.reference.pose_true
    error, least = rms(np.hypot(*off.T)), rms(np.hypot(*others[is_right, :2].T))
    if not error > _WORSE * least:
        return
    scenario = run.task.scenario
    px = scenario.area[0] / frame_size(scenario)[0]
    bias = off.mean(axis=0)
    if np.hypot(*bias) > _BIASED * error:
        yield run.problem(
            "off by a constant",
            f"its positions are off by ({bias[0]:+.2f}, {bias[1]:+.2f}) px on average, wherever "
            f"the robot is; a pixel of the frame is {px:.3g} px wide. An integer is a pixel's "
            "centre: step.frame.plane_map.to_world((u, v)) says where it lies in the work area",
        )
        return
    yield run.problem(
        "inexact",
        f"its positions have an error of {error:.2f} px, root mean square, those of the reference "
        f"{least:.2f} px, in the same noise, though they are not off by a constant. Are they exact "
        f"to a part of a pixel? A pixel of the frame is {px:.3g} px wide: the centroid of a blob "
        "is exact to a fraction of that, its box and rounded places are not",
    )
