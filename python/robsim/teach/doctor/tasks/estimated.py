"""What the worst run of a state estimator shows, beside the reference in the same run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.estimation.evaluation.errors import wrapped_error
from robsim.teach.doctor.tasks.seen_run import SeenRun, rms
from robsim.teach.tasks.trial import TaskTrial
from robsim.trace import Trace

_SETTLED = 10  # steps
_NEARER, _FARTHER = 0.75, 1.25  # times as far from the measurements as the reference
_WORSE_UNSEEN = 1.5  # times as much worse than the reference as where it is seen
_WORSE = 1.3  # times the error of the reference
_CONFIDENT = 2.0  # mean NEES / 3

_R = "R, the noise of the measurements, is too {}"
_Q = "Q, that of the model, is too {}"


def state_findings(trial: TaskTrial) -> Iterator[Problem]:
    """Yield what the worst run of a state estimator shows."""
    if (run := SeenRun.of(trial)) is None:
        return
    off, least = (_from_measurements(one) for one in (run.trace, run.reference))
    closeness = _ratio(off, least)
    is_seen = run.trace.seen[_SETTLED:]
    own, others = (_pose_errors(one) for one in (run.trace, run.reference))
    seen, unseen = (_ratio(own[there], others[there]) for there in (is_seen, ~is_seen))
    if unseen > _WORSE_UNSEEN * seen and closeness > _NEARER:
        yield _prediction(run, seen, unseen)
    elif not _NEARER < closeness < _FARTHER:
        yield _gain(run, closeness, trial.statistics.get("consistency", np.nan))
    elif unseen > _WORSE and unseen > seen:
        yield _prediction(run, seen, unseen)


def _prediction(run: SeenRun, seen: float, unseen: float) -> Problem:
    return run.problem(
        "prediction",
        f"where the robot is not seen its error is {unseen:.2g} times that of the reference, where "
        f"it is seen {seen:.2g} times: look at the prediction, the model and step.last_u, the "
        "input that has acted since the step before",
        k=int((~run.trace.seen[_SETTLED:]).argmax()) + _SETTLED,
    )


def _gain(run: SeenRun, closeness: float, consistency: float) -> Problem:
    """Return why it follows the measurements too closely, or too little.

    By its covariance, if that is a matter of R or of Q: wrong ones of the other kind are too large.
    """
    is_near, is_confident = closeness < _NEARER, consistency > _CONFIDENT
    what = "follows their noise" if is_near else "listens to them too little"
    if is_near:
        cause = _R.format("small") if is_confident else _Q.format("large")
    elif is_confident:
        cause = _Q.format("small")
    else:
        cause = f"{_R.format('large')}, or it leaves some of them out"
    return run.problem(
        "gain too large" if is_near else "gain too small",
        f"its estimates are {closeness:.2g} times as far from the measurements as those of the "
        f"reference: it {what}. Its mean NEES is {consistency:.2g} times what it should be: "
        f"{cause}",
    )


def _pose_errors(trace: Trace) -> Floats:
    return wrapped_error(trace.pose_estimated, trace.pose_true)[_SETTLED:]


def _from_measurements(trace: Trace) -> Floats:
    return wrapped_error(trace.pose_estimated, trace.pose_measured)[_SETTLED:]


def _ratio(own: Floats, others: Floats) -> float:
    """Return how many times as large errors (N, 3) are, as the geometric mean over the axes."""
    ratios = [max(rms(own[:, i]), 1e-9) / rms(others[:, i]) for i in range(3)]
    return float(np.exp(np.mean(np.log(ratios))))
