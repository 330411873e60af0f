"""Check a covariance against the errors, and the inputs against the motion out of sight."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from types import CodeType, FrameType
from typing import Any

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.source_line import SourceLine
from robsim.teach.doctor._lines import (
    line_of_covariance,
    line_of_measurement,
    line_that_reads,
    nodes_of,
)
from robsim.teach.doctor._situations import MEASUREMENT_SIGMA, UNSEEN, WAY
from robsim.teach.doctor._trial import Trial
from robsim.teach.doctor.gain import Gains, named, stopped_listening
from robsim.teach.doctor.trials import SETTLED, Trials, distances, errors, variances

# Mean NEES: 3 for a consistent filter. Q and R tuned 4 times too large or small: 0.5 to 12.
_TOO_SURE = 20.0
_SHARPER = 0.1  # the best camera's noise, relative to the situation's
_TOO_CAUTIOUS = 0.02  # mean of e^2 / P of a component: 1 if consistent
_LAG = 0.5  # steps; filters with a model have less than 0.2
# Out of sight P grows, and with the next measurement it falls to about R: by a factor of 1 - gain.
_KEPT = 0.9  # share of the variance left
_LISTENS = 0.5  # gain above which half at most must be left
_CERTAIN = 0.9  # gain above which one measurement's variance is left.
_SUNK = 0.15  # of the variance before the gap; it must be at least that, 1
_FIRST = 0.02  # the same after the very first measurement


def growth_problem(trials: Trials) -> Problem | None:
    P = variances(trials.gap)
    if (P[UNSEEN[-1]] > P[UNSEEN[0] - 1]).any():
        return None
    return trials.gap.problem(
        "covariance does not grow",
        f"after {len(UNSEEN)} steps without a measurement no variance is larger than at first: the "
        "covariance has to grow while the robot is not seen",
        UNSEEN[-1],
        line_of_covariance(trials.estimator),
    )


def reduction_problem(trials: Trials, gains: Gains) -> Problem | None:
    """Return a problem if a measurement does not reduce the covariance, or reduces it too far.

    A Kalman filter has P+ = (1 - K) P-. After a gap, K is near 1 and P+ = R, which is more
    than P of a robot that is seen at every step.
    """
    P, K = variances(trials.gap), gains.after_gap
    before, unseen, after = P[UNSEEN[0] - 1], P[UNSEEN[-1]], P[UNSEEN.stop]
    is_kept = (after > _KEPT * unseen) & (K > _LISTENS)
    if is_kept.any():
        return trials.gap.problem(
            "covariance not reduced",
            "when the robot is seen again the estimate follows the measurement (gain "
            f"{K[is_kept].max():.2g}), but the variance of {named(is_kept)} stays "
            f"{(after / unseen)[is_kept].max():.2g} times its previous value: a measurement has "
            "to reduce the variance, P = (I - K H) P",
            UNSEEN.stop,
            line_of_covariance(trials.estimator),
        )
    first, unborn = variances(trials.late)[5], variances(trials.late)[4]
    # All components at once: a particle filter with few particles left has random gains.
    is_followed = ((K > _CERTAIN) & (K < 2 - _CERTAIN)).all()
    is_sunk = np.full(3, is_followed and (after < _SUNK * before).all())
    is_sunk |= (first < _FIRST * before) & (unborn > before)
    if not is_sunk.any():
        return None
    return trials.gap.problem(
        "covariance reduced too far",
        f"after one measurement its variance of {named(is_sunk)} is smaller than after many in a "
        "row: after a long time unseen, one measurement reduces P to about R, not further. "
        "P = (I - K H) P (I - K H)' lacks its + K R K', or K belongs to another P; "
        "from P alone these cannot be distinguished",
        UNSEEN.stop,
        line_of_covariance(trials.estimator),
    )


def ahead_problem(trials: Trials) -> Problem | None:
    lead = -_lag(trials.seen)
    if lead < _LAG:
        return None
    return trials.seen.problem(
        "estimate ahead",
        f"its estimate is {lead:.2g} of its steps ahead of the robot: it returns the prediction "
        "for the next step, or predicts after the update and again before the next one; the "
        "estimate of a step is the result of the update with the measurement of this step",
    )


def lost_problem(trials: Trials) -> Problem | None:
    if not trials.is_lost_after_gap:
        return None
    distance, angle = distances(trials.gap)
    return trials.gap.problem(
        "lost after a gap",
        f"{len(distance) - UNSEEN.stop} steps after the robot is seen again its estimate is "
        f"{distance[-1]:.3g} px and {np.degrees(angle[-1]):.0f} degrees off: if the filter rejects "
        "measurements far from the prediction, its limit has to grow with P, or it must accept "
        "them after some steps; otherwise its covariance does not grow",
        len(distance) - 1,
        line_of_measurement(trials.estimator),
    )


_NEVER_SEEN = 0.1  # of the variances before the first measurement, after one unseen step
_RESTS = 0.3  # of the true way
_OVERSHOOTS = 1.01  # of a displacement of all measurements; without a speed it reaches 1 at most


def thrown_problem(trials: Trials, gains: Gains) -> Problem | None:
    """Return a problem if an estimator loses its state at the first step without a measurement."""
    k = UNSEEN.start
    last, first = trials.gap.outputs[k - 1 : k + 1, :3]
    P, unborn = variances(trials.gap), variances(trials.late)[0]
    jump = np.hypot(*(first - last)[:2])
    has_speed = bool((gains.in_time[:, :2].max(axis=0) > _OVERSHOOTS).all())
    if jump > WAY:
        what = f"its estimate jumps by {jump:.3g} px"
    elif (P[k] > _NEVER_SEEN * unborn).all() and (P[k] > P[k - 1] / _NEVER_SEEN).all():
        what = "its covariance is as large as before the first measurement"
    elif has_speed and trials.way_in_gap < _RESTS:
        what = (
            f"it moves {trials.way_in_gap:.2g} times as far as the robot, although it has a speed"
        )
    else:
        return None
    return trials.gap.problem(
        "state thrown away",
        f"at a step without a measurement {what}: keep pose, speed and P, and only predict",
        k,
        line_that_reads(trials.estimator, "measurement"),
    )


def size_problem(trials: Trials, gains: Gains) -> Problem | None:
    if nees(trials.seen) <= _TOO_SURE:
        return None
    sharper = trials.estimator.try_in(trials.weaves.with_noise(_SHARPER))
    if sharper.error is not None or nees(sharper) <= _TOO_SURE:
        return None
    kind, cause = stopped_listening(gains) or (
        "covariance too small",
        "check R and Q (variances, in px^2 and rad^2), and P after the update",
    )
    return trials.seen.problem(
        kind,
        f"its errors are {np.sqrt(nees(trials.seen) / 3):.2g} times as large as its covariance "
        f"claims, and too large even for a camera with a tenth of the noise: {cause}",
        line=line_of_covariance(trials.estimator),
    )


def consistency_remarks(trials: Trials) -> Iterator[str]:
    noise = "noise here: {:g} px, {:g} px, {:g} rad".format(*MEASUREMENT_SIGMA)
    lag = _lag(trials.seen)
    if lag > _LAG:
        yield f"its estimate lags {lag:.2g} steps behind the robot, like a low-pass filter"
    if nees(trials.seen) > _TOO_SURE:
        yield (
            f"its errors are {np.sqrt(nees(trials.seen) / 3):.2g} times as large as it claims: "
            f"right only for a camera with less noise ({noise})"
        )
    e, P = errors(trials.seen)[SETTLED:], variances(trials.seen)[SETTLED:]
    share = np.mean(e**2 / P, axis=0)
    is_vague = share < _TOO_CAUTIOUS
    if is_vague.any():
        factor = 1 / np.sqrt(share[is_vague].min())
        yield (
            f"its errors of {named(is_vague)} are {factor:.2g} times smaller than it claims: R or "
            f"Q is meant for more noise ({noise}), or a standard deviation is used as a "
            "variance; the doctor does not know your camera, so it cannot distinguish these"
        )


def nees(trial: Trial) -> float:
    """Return the mean of e' P^-1 e, without the errors of mere lag behind the robot."""
    e, P = _without_lag(trial)[SETTLED:], trial.outputs[SETTLED:, 3:12].reshape(-1, 3, 3)
    P = (P + P.transpose(0, 2, 1)) / 2
    return float(np.mean(np.sum(e * np.linalg.solve(P, e[:, :, None])[:, :, 0], axis=1)))


def _lag(trial: Trial) -> float:
    """Return the steps by which the estimate lags: the error relative to the displacement."""
    e, way = errors(trial)[SETTLED:, :2], np.diff(trial.situation.poses[:, :2], axis=0)
    way = way[SETTLED - 1 : len(e) + SETTLED - 1]
    return float(-np.sum(e * way) / np.sum(way**2))


def _without_lag(trial: Trial) -> Floats:
    e = errors(trial)
    poses = trial.situation.poses[: len(e)]
    way = np.vstack((np.zeros(3), np.diff(poses, axis=0)))
    # the least squares fit of the errors by the displacement in a step, component by component
    tau = np.sum((e * way)[SETTLED:], axis=0) / np.sum(way[SETTLED:] ** 2, axis=0)
    return np.asarray(e - tau * way)


_STEPS = 12
_ASYMMETRY = 1e-9  # of the largest entry


def transpose_problem(trials: Trials) -> Problem | None:
    """Return the first line that multiplies by the same unsymmetric matrix on both sides."""
    suspects: dict[tuple[str, int], tuple[SourceLine, str, CodeType]] = {}
    for line, node in nodes_of(trials.estimator):
        factor = _factor(node)
        if factor is not None:
            code = compile(ast.Expression(factor), line.file, "eval")
            suspects[line.file, line.number] = (line, ast.unparse(node), code)
    if not suspects:
        return None
    unsymmetric = _unsymmetric(trials, {where: code for where, (*_, code) in suspects.items()})
    for where, (line, text, _) in suspects.items():
        if where in unsymmetric:
            return trials.seen.problem(
                "missing transpose",
                f"it computes {text}, with the same matrix on both sides, which is not symmetric: "
                "a covariance becomes F P F', in Python F @ P @ F.T",
                line=line,
            )
    return None


def _factor(node: ast.AST) -> ast.expr | None:
    """Return F of the product F P F; None = it is another expression."""
    factors = _factors(node)
    if len(factors) != 3 or not _is_named(factors[0]):
        return None
    return factors[0] if ast.dump(factors[0]) == ast.dump(factors[2]) else None


def _factors(node: Any) -> list[ast.expr]:
    """Return the factors of a matrix product: A @ B, A.dot(B), np.dot(A, B), np.matmul(A, B)."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return _factors(node.left) + _factors(node.right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        if node.func.attr in ("dot", "matmul") and len(node.args) == 2:
            return _factors(node.args[0]) + _factors(node.args[1])
        if node.func.attr == "dot" and len(node.args) == 1:
            return _factors(node.func.value) + _factors(node.args[0])
    return [node]


def _is_named(node: ast.AST) -> bool:
    """Return whether it is a plain name such as F or self.F, which can be looked up again."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name)


def _unsymmetric(trials: Trials, codes: dict[tuple[str, int], CodeType]) -> set[tuple[str, int]]:
    """Return the places of unsymmetric factors during a trial."""
    found = set()
    files = {file for file, _ in codes}

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        file = frame.f_code.co_filename
        if file not in files:
            return None
        code = codes.get((file, frame.f_lineno)) if event == "line" else None
        if code is not None and _is_unsymmetric(code, frame):
            found.add((file, frame.f_lineno))
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        trials.estimator.try_in(trials.weaves.first(_STEPS))
    finally:
        sys.settrace(before)
    return found


def _is_unsymmetric(code: CodeType, frame: FrameType) -> bool:
    try:
        F = np.asarray(eval(code, frame.f_globals, frame.f_locals), dtype=float)
    except Exception:
        return False  # not there yet
    return F.ndim == 2 and bool(abs(F - F.T).max() > _ASYMMETRY * abs(F).max())
