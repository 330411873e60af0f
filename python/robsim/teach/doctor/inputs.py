"""The response of an estimate to the inputs while the robot is not seen.

In a second run the left motor has more voltage. If the estimator has the robot's model, the
estimate changes like the robot.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._lines import line_that_reads
from robsim.teach.doctor._situations import UNSEEN
from robsim.teach.doctor.trials import Trials

# Right ones: at least 0.9, crude models 9.
_NOTHING = 0.2
_STRAIGHT = 3  # steps
_TOO_FAR = 1.5  # also of the true way; twice the prediction gives 1.8, a crude model 1.2

_SWAPPED = (
    "inputs swapped",
    "its heading turns the other way: u[0] is the left motor, u[1] the right one, and the heading "
    "grows clockwise on the image, because y points down; these cannot be distinguished, because "
    "both mirror the turn",
)
_NEGATED = ("inputs of wrong sign", "it moves the other way: positive voltages drive forward")
_NO_TURN = (
    "turn missing",
    "its heading does not change: predict it too, from the difference of the two voltages",
)
_TOO_LARGE = (
    "moves too far",
    "it moves further than the robot: it predicts twice in a step, its dt is too large, or "
    "its inputs are: these cannot be distinguished, because all of them add the same way",
)
_LATE = "inputs late"


def inputs_problems(trials: Trials) -> Iterator[Problem | str]:
    """Yield faults of the motion that an estimator predicts from the inputs."""
    own, true = trials.response
    if not own.any():
        return
    late = int(own.any(axis=1).argmax()) - 1  # u(k) moves the robot from step k to k + 1
    turn = own[late + 1 :][:_STRAIGHT, 2].sum() / true[1:][:_STRAIGHT, 2].sum()
    # At first it goes straight on, by its own heading.
    heading = trials.gap.outputs[UNSEEN.start :, 2]
    way = _ahead(own[late + 1 :], heading) / _ahead(
        true[1:], trials.weaves.poses[UNSEEN.start :, 2]
    )
    found = None
    if way < -_NOTHING:
        found = _NEGATED
    elif turn < -_NOTHING:
        found = _SWAPPED
    elif min(trials.way_in_gap, way) > _TOO_FAR:
        found = _TOO_LARGE
    elif turn < _NOTHING < way:
        found = _NO_TURN
    line = line_that_reads(trials.estimator, "last_u", "u")
    if found is not None:
        kind, cause = found
        sentence = f"with more voltage on the left motor, while the robot is not seen, {cause}"
        yield trials.gap.problem(kind, sentence, UNSEEN.stop - 1, line)
    if late == 1 and _responds_at_once(trials):
        return
    if late > 0:
        steps = "a step" if late == 1 else f"{late} steps"
        yield trials.gap.problem(
            _LATE,
            f"an input changes its estimate {steps} later than the robot moves: step.last_u is the "
            "input that has moved the robot since the last step; use step.last_u, not an earlier "
            "input, and move the pose with the new speed",
            UNSEEN.start + 1 + late,
            line,
        )


def _ahead(change: Floats, heading: Floats) -> float:
    forward = np.column_stack((np.cos(heading), np.sin(heading)))[:_STRAIGHT]
    return float(np.sum(change[:_STRAIGHT, :2] * forward[: len(change)]))


def _responds_at_once(trials: Trials) -> bool:
    """Return whether its speed responds at once, as in Euler's method with its late pose."""
    u = trials.pushed.situation.u[UNSEEN.start]
    kept = trials.kept.get("gap", []), trials.kept.get("pushed", [])
    if [one.shape for one in kept[0]] != [one.shape for one in kept[1]]:
        return True
    changed = [after[after != before] for before, after in zip(*kept, strict=True)]
    return any(not np.isin(values, u).all() for values in changed)
