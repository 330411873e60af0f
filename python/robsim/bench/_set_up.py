"""The benchmark of short runs without frames, where the set-up counts, against a numpy loop."""

from __future__ import annotations

import itertools

import numpy as np

from robsim._base.checks import Floats
from robsim._core import DriveAround, RobotModel
from robsim.bench._cases import Call
from robsim.simulation import Scenario, Simulation

STEPS = 100

_HOLD = 10  # steps
_START = (600.0, 600.0, 0.0)


def set_up_calls(*, is_new: bool) -> dict[str, Call]:
    """Return the calls that make a run of another seed each time, by robsim and in numpy.

    Parameters
    ----------
    is_new : bool
        A new simulation for each run; otherwise one is reset.

    Returns
    -------
    dict of str to callable
        ``"ours"`` and ``"numpy"``. Each call returns the path (100, 3).

    Raises
    ------
    RuntimeError
        If the two paths differ for the same inputs.
    """
    scenario = Scenario(
        control=DriveAround(hold=_HOLD), boundary="unlimited", start=_START, robot="lab"
    )
    simulation = Simulation(scenario)
    seeds = itertools.count()
    trace = simulation.run(STEPS)
    if not np.allclose(_numpy_path(trace.u), trace.pose_true, atol=1e-6):
        raise RuntimeError("the paths of robsim and numpy differ")

    def new() -> Floats:
        return Simulation(scenario, seed=next(seeds)).run(STEPS).pose_true

    def again() -> Floats:
        simulation.reset(seed=next(seeds))
        return simulation.run(STEPS).pose_true

    def numpy() -> Floats:
        rng = np.random.default_rng(next(seeds))
        return _numpy_path(np.repeat(rng.uniform(-0.5, 1.5, (STEPS // _HOLD, 2)), _HOLD, axis=0))

    return {"ours": new if is_new else again, "numpy": numpy}


def _numpy_path(u: Floats) -> Floats:
    """Return the path of the default robot for inputs (N, 2), step by step."""
    a1, a2, b1, b2, d1 = RobotModel().theta.T
    path = np.empty((len(u), 3))
    path[0] = pose_2 = pose_1 = np.array(_START)
    for k in range(1, len(u)):
        direction = np.array([np.cos(pose_1[2]), np.sin(pose_1[2]), 1.0])
        # pose(k) = a1 pose(k-1) + a2 pose(k-2) + (b1 u1 + b2 u2 + d1) (cos, sin, 1)
        pose = a1 * pose_1 + a2 * pose_2 + (b1 * u[k - 1, 0] + b2 * u[k - 1, 1] + d1) * direction
        path[k] = pose
        pose_1, pose_2 = pose, pose_1
    path[:, 2] = (path[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return path
