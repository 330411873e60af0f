"""Whether the inputs help: the gap without measurements again, with inputs that were not given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._lines import line_that_reads
from robsim.teach.doctor._situations import UNSEEN, WAY
from robsim.teach.doctor.trials import Trials, distances

# The errors of right filters are no smaller with exchanged or negated inputs, those of wrong ones 3
# to 10 times, with a crude model 1.7 times.
_BETTER = 0.7
_MINIMUM_ERROR = 0.3  # of WAY, or rad; below it the prediction is good
_TOO_FAR = 1.5  # of the true way; twice the prediction gives 1.8, a crude model 1.2
_SCALES = {"half as large": 0.5, "taken as 0": 0.0}


def inputs_problem(trials: Trials) -> Problem | None:
    """Return whether the pose in a gap is predicted much better with other inputs."""
    if trials.ignores_inputs:
        return None
    u = trials.weaves.u
    given = _error(trials, u)
    others = {"exchanged": u[:, ::-1], "negated": -u}
    others |= {name: scale * u for name, scale in _SCALES.items()}
    found = {name: _error(trials, one) for name, one in others.items()}
    better = {name: error for name, error in found.items() if _is_better(error, given)}
    if trials.way_in_gap < _TOO_FAR:  # a model that is crude
        better = {name: error for name, error in better.items() if name not in _SCALES}
    if not better:
        return None
    best = min(better, key=lambda name: float(better[name].sum()))
    factor = (given / np.maximum(better[best], 1e-3))[given > _MINIMUM_ERROR].max()
    kind, cause = _cause(best)
    return Problem(
        kind=kind,
        sentence=f"with the inputs {best} it predicts the pose while the robot is not seen "
        f"{factor:.2g} times better than with those given: {cause}",
        situation="robot out of sight",
        k=UNSEEN.stop - 1,
        line=line_that_reads(trials.estimator, "last_u", "u"),
    )


def _error(trials: Trials, u: Floats) -> Floats:
    """Return the mean errors in the gap: distance in units of the way of ten steps, angle (rad)."""
    situation = replace(trials.gap.situation, u=np.ascontiguousarray(u)).first(UNSEEN.stop)
    trial = trials.gap if u is trials.weaves.u else trials.estimator.try_in(situation)
    if trial.error is not None:
        return np.full(2, np.inf)
    distance, angle = (part[UNSEEN.start : UNSEEN.stop] for part in distances(trial))
    return np.array((np.mean(distance) / WAY, np.mean(angle)))


def _is_better(error: Floats, given: Floats) -> bool:
    """Return whether an error, in distance and angle, is much smaller than that given."""
    is_halved = (given > _MINIMUM_ERROR) & (error < _BETTER * given)
    return bool(is_halved.any() and error.sum() < given.sum())


def _cause(best: str) -> tuple[str, str]:
    if best == "exchanged":
        return (
            "inputs swapped",
            "u[0] is the left motor, u[1] the right one; or its heading turns the other way (it "
            "grows clockwise on the image, as y points down): these cannot be told apart, since "
            "both mirror the turn",
        )
    if best == "negated":
        return "inputs of wrong sign", "positive voltages drive forward"
    return (
        "moves too far",
        "it moves further than the robot does: it predicts twice in a step, its dt is too large, "
        "or its inputs are: these cannot be told apart, since all of them add the same way",
    )
