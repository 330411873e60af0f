"""The worst run of an estimator or a measurement, next to the reference in the same run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.estimation.evaluation.errors import wrapped_error
from robsim.simulation.world.world_of_scenario import frame_size
from robsim.teach.doctor.callbacks.pose_mistakes import are_right, mistakes
from robsim.teach.doctor.task_checks.seen_run import SeenRun, rms
from robsim.trace.trace import Bools

_SETTLED = 10  # steps
_NEARER, _FARTHER = 0.75, 1.25  # times as far from the measurements as the reference.
_WORSE_UNSEEN = 1.5  # ratio to the reference while unseen, over the ratio while seen
_WORSE = 1.3  # times the error of the reference
_CONFIDENT = 2.0  # mean NEES / 3.
_R = "R, the noise of the measurements, is too {}"
_Q = "Q, the noise of the model, is too {}"


def state_findings(run: SeenRun) -> Iterator[Problem]:
    both = (run.trace, run.reference)
    off, least = (wrapped_error(one.pose_estimated, one.pose_measured)[_SETTLED:] for one in both)
    closeness = _ratio(off, least)
    is_seen = run.trace.seen[_SETTLED:]
    own, others = (wrapped_error(one.pose_estimated, one.pose_true)[_SETTLED:] for one in both)
    seen, unseen = (_ratio(own[there], others[there]) for there in (is_seen, ~is_seen))
    if unseen > _WORSE_UNSEEN * seen and closeness > _NEARER:
        yield _prediction(run, seen, unseen)
    elif not _NEARER < closeness < _FARTHER:
        yield _gain(run, closeness, run.trial.statistics.get("consistency", np.nan))
    elif unseen > _WORSE and unseen > seen:
        yield _prediction(run, seen, unseen)


def _prediction(run: SeenRun, seen: float, unseen: float) -> Problem:
    return run.problem(
        "prediction",
        f"where the robot is not seen its error is {unseen:.2g} times the reference's, where "
        f"it is seen {seen:.2g} times: check the prediction, the model and step.last_u, the "
        "input that has acted since the previous step",
        k=int((~run.trace.seen[_SETTLED:]).argmax()) + _SETTLED,
    )


def _gain(run: SeenRun, closeness: float, consistency: float) -> Problem:
    """Return a problem if it follows the measurements too closely, or too little.

    With an overconfident covariance R or Q is too small; otherwise R or Q is too large.
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
        f"its estimates are {closeness:.2g} times as far from the measurements as the "
        f"reference's: it {what}. Its mean NEES is {consistency:.2g} times the expected value: "
        f"{cause}",
    )


def _ratio(own: Floats, others: Floats) -> float:
    """Return the ratio of two errors (N, 3), as the geometric mean over the axes."""
    ratios = [max(rms(own[:, i]), 1e-9) / rms(others[:, i]) for i in range(3)]
    return float(np.exp(np.mean(np.log(ratios))))


_TAKEN = 0.8  # of the samples that the reference takes
_EARLY, _LATE = 0.2, 0.6  # of a run: up to here it learns most, from here on it should have settled
_UNREST = 0.2  # late beside early; right ones have up to 0.03


def parameter_findings(run: SeenRun) -> Iterator[Problem]:
    own, others = (_changes(one.parameters) for one in (run.trace, run.reference))
    taken, offered = int((own > 0).sum()), int((others > 0).sum())
    if not taken:
        yield run.problem("no adaptation", "its parameters never change")
        return
    if taken < _TAKEN * offered:
        yield run.problem(
            "leaves samples out",
            f"its parameters change in {taken} steps, the reference's in {offered}: it "
            "leaves samples out, and each of them has information",
        )
    unrest, least = (_unrest(moves) for moves in (own, others))
    if unrest < _UNREST:
        return
    moves = (
        f"in the last 40 % of the run its parameters move {unrest:.2g} times as far as in the "
        f"first 20 %, the reference's {least:.2g} times"
    )
    if unrest > 1:
        yield run.problem(
            "gain stays",
            f"{moves}: its gain does not become smaller with the samples that it has seen. Reduce "
            "P by each, P = P - outer(K, phi @ P); a gradient method has no P",
        )
    else:
        yield run.problem(
            "does not settle",
            f"{moves}: either it forgets too fast, and the forgetting factor must be nearer to 1; "
            "or it begins with too small a P, and learns too slowly: begin with a large one",
        )


def _unrest(moves: Floats) -> float:
    n = len(moves)
    late, early = moves[round(_LATE * n) :].sum(), moves[: round(_EARLY * n)].sum()
    return float(late / early) if early else 0.0


def _changes(theta: Floats) -> Floats:
    """Return how far the parameters (N, 3, 5) move in each step; 0 before the first ones."""
    moves = np.diff(np.nan_to_num(theta), axis=0).reshape(len(theta) - 1, -1)
    is_first = ~np.isfinite(theta[:-1]).all(axis=(1, 2))
    return np.where(is_first, 0.0, np.linalg.norm(moves, axis=1))


_LEAST = 5  # poses
_SEVERAL = 0.05  # of the frames
_BIASED = 0.5  # of the error


def measured_findings(run: SeenRun) -> Iterator[Problem]:
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
            "false detection",
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
    trace, other = run.trace, run.reference
    false = trace.is_false & is_visible
    there = ~trace.hidden.astype(bool)
    lost, lost_there = (int((there & ~one.seen).sum()) for one in (trace, other))
    if false.sum() > _SEVERAL * len(trace):
        yield run.problem(
            "false poses",
            f"{false.sum()} of its {is_visible.sum()} poses are false, "
            f"{int((other.is_false).sum())} of the reference's: in noise there are other red and "
            "blue blobs; of all pairs take the pair at the distance of the markers",
            k=int(false.argmax()),
        )
    if lost - lost_there > _SEVERAL * len(trace):
        yield run.problem(
            "not found",
            f"it does not find the robot in {lost} of the {there.sum()} frames that show it, "
            f"the reference in {lost_there}",
            k=int((there & ~trace.seen).argmax()),
        )


def _inexact(run: SeenRun, is_right: Bools) -> Iterator[Problem]:
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
            "centre: step.frame.plane_map.to_world((u, v)) gives its place in the work area",
        )
        return
    yield run.problem(
        "inexact",
        f"its positions have an error of {error:.2f} px, root mean square, the reference's "
        f"{least:.2f} px, in the same noise, without a constant offset. Are they exact "
        f"to a part of a pixel? A pixel of the frame is {px:.3g} px wide: the centroid of a blob "
        "is exact to a fraction of that, its box and rounded places are not",
    )
