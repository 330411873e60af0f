"""The benchmark of the estimators against numpy, and of the simulation loop."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from robsim._base.checks import Floats
from robsim._core import DriveAround, Estimate, RecursiveLeastSquares, Step, least_squares
from robsim.simulation._simulation import Simulation

RECURSIVE_SAMPLES = 5_000
BATCH_SAMPLES = 10_000
LOOP_STEPS = 200_000
PARAMETERS = 5
AXES = 3

Call = Callable[[], Any]


class TextbookRecursiveLeastSquares:
    """Recursive least squares in numpy, in its textbook form.

    Parameters
    ----------
    n_parameters : int
        Number of parameters.
    forgetting : float
        Forgetting factor, 0 < forgetting <= 1.
    initial_covariance : float
        The initial P is this times the identity matrix; the initial theta is 0.

    Notes
    -----
    Source: Ljung, System Identification, 1999, 11.2.
    """

    def __init__(
        self, n_parameters: int, *, forgetting: float = 1.0, initial_covariance: float = 1e6
    ) -> None:
        self.forgetting = forgetting
        self.theta: Floats = np.zeros(n_parameters)
        self.P: Floats = initial_covariance * np.eye(n_parameters)

    def update(self, phi: Floats, y: float) -> Floats:
        """Update with a sample and return theta, an array (n_parameters,)."""
        # K = P phi/(lambda + phi' P phi)
        P_phi = self.P @ phi
        K = P_phi / (self.forgetting + phi @ P_phi)
        # theta <- theta + K (y - phi' theta)
        self.theta = self.theta + K * (y - phi @ self.theta)
        # P <- (P - K phi' P)/lambda, made symmetric: its rounding errors would grow as lambda^-k
        P = (self.P - np.outer(K, P_phi)) / self.forgetting
        self.P = (P + P.T) / 2
        return self.theta


def recursive_calls(n_samples: int = RECURSIVE_SAMPLES) -> dict[str, Call]:
    """Return the recursive least-squares calls to be timed, after a check that both agree.

    Parameters
    ----------
    n_samples : int
        Number of samples per call.

    Returns
    -------
    dict of str to callable
        ``"ours"``: the three axes of a robot, all samples in one call. ``"numpy"``: one axis, one
        call per sample.

    Raises
    ------
    RuntimeError
        If the two estimates differ.
    """
    random = np.random.default_rng(1)
    phi = random.normal(size=(n_samples, AXES, PARAMETERS))
    y = phi.sum(axis=2) + 0.1 * random.normal(size=(n_samples, AXES))
    options = {"forgetting": 0.999, "initial_covariance": 1e6}

    def ours() -> Floats:
        filters = RecursiveLeastSquares(PARAMETERS, n_filters=AXES, **options)
        filters.update(phi, y)
        return filters.theta

    def numpy(axis: int = 0) -> Floats:
        filter_ = TextbookRecursiveLeastSquares(PARAMETERS, **options)
        for row, output in zip(phi[:, axis], y[:, axis], strict=True):
            filter_.update(row, output)
        return filter_.theta

    _check_same(ours(), np.array([numpy(axis) for axis in range(AXES)]))
    return {"ours": ours, "numpy": numpy}


def batch_calls(n_samples: int = BATCH_SAMPLES) -> dict[str, Call]:
    """Return the batch least-squares calls to be timed, after a check that both agree.

    Parameters
    ----------
    n_samples : int
        Number of samples, each of five regressors.

    Returns
    -------
    dict of str to callable
        ``"ours"``: `least_squares`, with rank and condition. ``"numpy"``: ``numpy.linalg.lstsq``.

    Raises
    ------
    RuntimeError
        If the two solutions differ.
    """
    random = np.random.default_rng(1)
    phi = random.normal(size=(n_samples, PARAMETERS))
    y = phi.sum(axis=1) + 0.1 * random.normal(size=n_samples)
    _check_same(least_squares(phi, y).theta, np.linalg.lstsq(phi, y, rcond=None)[0])
    return {
        "ours": lambda: least_squares(phi, y),
        "numpy": lambda: np.linalg.lstsq(phi, y, rcond=None),
    }


def _check_same(ours: Floats, theirs: Floats) -> None:
    if not np.allclose(ours, theirs, rtol=1e-9, atol=1e-12):
        raise RuntimeError(f"robsim and numpy must find the same theta, got {ours} and {theirs}")


def _small_controller(step: Step) -> tuple[float, float]:
    return (1.0, 0.2) if step.k % 20 < 10 else (0.2, 1.0)


def loops() -> dict[str, Simulation]:
    """Return the simulations whose steps are to be timed, without rendering and tracking.

    Returns
    -------
    dict of str to Simulation
        ``"native"``: drives around, with recursive least squares, no Python. ``"controller"``: the
        same with one small controller in Python. ``"five_callbacks"``: each of the five stages of
        a step is a trivial Python function.
    """
    estimate = Estimate((600, 600, 0), np.eye(3))
    options: dict[str, Any] = {"robot": "lab", "boundary": "unlimited", "seed": 1}
    return {
        "native": Simulation(control=DriveAround(), estimate_parameters=True, **options),
        "controller": Simulation(control=_small_controller, estimate_parameters=True, **options),
        "five_callbacks": Simulation(
            evaluate_model=lambda world: (600.0, 600.0, 0.0),
            estimate_parameters=lambda step: None,
            measure=lambda step: None,
            estimate_state=lambda step: estimate,
            control=lambda step: (0.0, 0.0),
            **options,
        ),
    }


def steps_per_second(simulation: Simulation, *, steps: int = LOOP_STEPS, rounds: int = 5) -> float:
    """Return the median rate of a simulation from its second run on (steps/s).

    The first run allocates the trace's memory, the first step of a run includes its set-up:
    neither is timed.

    Parameters
    ----------
    simulation : Simulation
        The simulation; it is reset before each run.
    steps : int
        Number of steps of a run.
    rounds : int
        Number of timed runs.
    """
    times = []
    for _ in range(1 + rounds):
        simulation.reset()
        simulation.step()
        start = time.perf_counter()
        simulation.run(steps)
        times.append(time.perf_counter() - start)
    return steps / statistics.median(times[1:])
