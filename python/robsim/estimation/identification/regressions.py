"""The regression samples of a recorded run, for the batch estimates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import check_mean_interval, model_steps, regression
from robsim.base.checks import Floats, check_choice
from robsim.trace import Trace
from robsim.trace.columns import POSES
from robsim.trace.timing import check_delay, delayed
from robsim.trace.trace import check_trace, longest_run

SELECTIONS = ("valid", "longest", "all")


@dataclass(frozen=True, kw_only=True, eq=False)
class Regression:
    """Samples of the robot model's predictor: y = sum(phi * theta, axis=2).

    Attributes
    ----------
    phi : array (N, 3, 5)
        Regressors of the axes X, Y and P (heading).
    y : array (N, 3)
        Outputs x, y (work-area px) and heading (rad).
    k : array (N,) of int
        The step of the output y; its regressors are from the two previous steps.
    identify_from : str
        The poses of the samples: truth, measurement or estimate.
    left_out : int
        Number of samples omitted because they span a bounce, a missing pose or lost frames.

    Examples
    --------
    >>> trace = robsim.Simulation(seed=1, control=robsim.DriveAround()).run(100)
    >>> samples = robsim.estimation.regression_of(trace)
    >>> theta = np.linalg.lstsq(samples.phi[:, 2], samples.y[:, 2])[0]
    >>> theta[:2].round(3)
    array([ 1.833, -0.833])
    """

    phi: Floats
    y: Floats
    k: NDArray[np.int64]
    identify_from: str
    left_out: int


def regression_of(
    trace: Trace,
    *,
    identify_from: str | None = None,
    select: str = "valid",
    motor_delay: float = 0.0,
) -> Regression:
    """Return the regression samples of a trace.

    Parameters
    ----------
    trace : Trace
        The recorded run.
    identify_from : str, optional
        ``"truth"``, ``"measurement"`` or ``"estimate"``. Default: the source of the trace's own
        online estimate.
    select : str
        ``"valid"``: all except those that span a bounce, a step without a pose or lost frames.
        ``"longest"``: the samples of the longest segment without an interruption. ``"all"``: also
        samples that span a bounce, which the model does not cover.
    motor_delay : float
        Delay of the inputs (steps of the model), 0..1000. A sample is not valid if its inputs
        precede the record or a stop, or if it spans lost frames.

    Returns
    -------
    Regression
        Regressors, outputs and their steps.

    Raises
    ------
    TypeError, ValueError
        If `trace` is not a Trace, or a name is unknown; if the time between two steps is not a
        multiple of the model's dt.

    Examples
    --------
    >>> trace = robsim.Simulation(seed=1, control=robsim.DriveAround()).run(100)
    >>> samples = robsim.estimation.regression_of(trace)
    >>> samples.phi.shape, samples.left_out
    ((98, 3, 5), 0)
    """
    check_trace(trace)
    source = trace.info.identify_from if identify_from is None else identify_from
    check_choice("identify_from", source, tuple(POSES))
    check_choice("select", select, SELECTIONS)
    delay = check_delay("motor_delay", motor_delay)
    poses = trace.poses_from(source)
    follows = _follows(poses, interruptions(trace, over_bounces=select == "all", motor_delay=delay))
    if select == "longest":
        longest = longest_run(follows)
        follows = np.isin(np.arange(len(follows)), np.arange(longest.start, longest.stop))
    # The sample of step k needs the poses of three consecutive steps.
    is_whole = follows[1:] & follows[:-1]
    phi, y = np.empty((0, 3, 5)), np.empty((0, 3))
    if is_whole.any():
        known = np.where(np.isfinite(poses).all(axis=1, keepdims=True), poses, 0.0)
        u = np.nan_to_num(inputs_of(trace, delay))
        phi, y = (rows[is_whole] for rows in regression(known, u))
    return Regression(
        phi=phi,
        y=y,
        k=trace.k[2:][is_whole],
        identify_from=source,
        left_out=0 if select == "longest" else int((~is_whole).sum()),
    )


def inputs_of(trace: Trace, motor_delay: float = 0.0) -> Floats:
    """Return the inputs (N, 2) that acted, in V: the reported ones, or else the sent ones."""
    u = trace.u.copy()
    received = trace.last_u[1:]
    is_known = np.isfinite(received).all(axis=1)
    u[:-1][is_known] = received[is_known]
    return delayed(u, motor_delay) if motor_delay else u


def interruptions(
    trace: Trace, *, over_bounces: bool = False, motor_delay: float = 0.0
) -> NDArray[np.bool_]:
    """Return for each step whether the model cannot predict it from the last two steps, (N,).

    It cannot across a bounce (except `over_bounces`), lost frames, or a stop in between. For
    `motor_delay` steps after lost frames or a stop, and at the start of a record that begins after
    step 0, inputs are not known. A
    time between two steps that is no multiple of the model's dt raises ValueError.
    """
    is_break = np.zeros(len(trace), dtype=bool)
    # The duration of a stop is arbitrary.
    intervals = np.diff(trace.t)[~trace.interrupted[1:]]
    steps = model_steps(intervals, trace.info.dt)
    check_mean_interval(intervals.sum(), steps.sum(), trace.info.dt)
    is_break[1:][~trace.interrupted[1:]] = steps > 1
    is_break |= trace.interrupted
    if motor_delay and len(trace):
        is_break[0] |= trace.k[0] > 0
        late = np.flatnonzero(is_break)[:, np.newaxis] + np.arange(1, math.ceil(motor_delay) + 1)
        is_break[late[late < len(trace)]] = True
    if not over_bounces:
        is_break |= trace.bounced
    return is_break


def _follows(poses: Floats, breaks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each of the steps 1.. whether its pose follows from the previous one."""
    seen = np.asarray(np.isfinite(poses).all(axis=1))
    return np.asarray(seen[1:] & seen[:-1] & ~breaks[1:])
