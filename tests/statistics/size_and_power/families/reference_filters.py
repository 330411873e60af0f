"""The filters of robsim.estimation.reference with their defaults, in simulated worlds."""

from functools import partial

import numpy as np

import robsim
from robsim.estimation import nees, nees_consistency, reference, wrapped_error
from size_and_power.trials import Row, Trials

_COORDINATES = 3


def nees_by_step(trace):
    """The NEES of the estimated pose at each step: a metric."""
    errors = wrapped_error(trace.pose_estimated, trace.pose_true)
    return {f"{k:04}": value for k, value in enumerate(nees(errors, trace.covariance))}


def reports(values, runs):
    """The reports on every so many runs, of values (R, N) of R runs in N steps.

    A verdict depends on the NEES alone: here it is that of (sqrt(NEES), 0, 0) and the identity.
    """
    errors = np.zeros((*values.shape, _COORDINATES))
    errors[..., 0] = np.sqrt(values)
    P = np.eye(_COORDINATES)
    covariances = np.broadcast_to(P, (runs, values.shape[1], *P.shape))
    return [
        nees_consistency(errors[first : first + runs], covariances)
        for first in range(0, len(errors), runs)
    ]


_RUNS, _STEPS = 20, 60
_NOISE = robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005)  # that of the defaults

# what is true: factors of the process and of the measurement noise, rate of rejections
_CASES = {
    "right": (1.0, 1.0, (0, 0.05)),
    "Q x 1/16": (0.25, 1.0, (0.95, 1)),
    "R x 1/16": (1.0, 0.25, (0.95, 1)),
    "R x 16": (1.0, 4.0, (0.95, 1)),
}


def _filter(process, measured):
    return partial(
        reference.ExtendedKalmanFilter,
        robsim.RobotModel(),
        process_sigma=process * _NOISE.sigma,
        measurement_sigma=[measured * sigma for sigma in (0.3, 0.3, 0.05)],
    )


def _rejected(numbers):
    values = np.transpose([numbers[name] for name in sorted(numbers)])
    return {"rejected": [one.verdict != "consistent" for one in reports(values, _RUNS)]}


TRIALS = (
    Trials(
        name="extended",
        scenario=robsim.Scenario(
            robot="lab",
            measure=True,
            boundary="unlimited",
            control=robsim.DriveAround(),
            process_noise=_NOISE,
        ),
        vary={"estimate_state": {name: _filter(q, r) for name, (q, r, _) in _CASES.items()}},
        metric=nees_by_step,
        answers=_rejected,
        rows={
            (name, "rejected"): Row(
                *("pose_consistency of the EKF", name, f"{_RUNS} runs of {_STEPS} steps"),
                *("rejected", promised),
            )
            for name, (_, _, promised) in _CASES.items()
        },
        steps=_STEPS,
        runs=_RUNS,
        share=0.03,  # 20 runs with a camera take a second
    ),
)
