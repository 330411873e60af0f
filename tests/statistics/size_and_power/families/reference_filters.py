"""The filters of robsim.estimation.reference with their defaults, in simulated worlds."""

from functools import partial

import numpy as np

import robsim
from nees_of_runs import nees_by_step, reports
from robsim.estimation import reference
from size_and_power.row import Row
from size_and_power.trials import Trials

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
