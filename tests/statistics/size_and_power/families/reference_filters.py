"""The filters of robsim.reference with their defaults, in simulated worlds."""

import robsim
from robsim import reference
from size_and_power.row import Row, counted

SHARE = 0.03  # 20 runs with a camera take a second

_RUNS, _STEPS = 20, 60
_NOISE = robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005)  # that of the defaults

# what is true, factors of the process and of the measurement noise -> rate of rejections
_CASES = {
    ("right", 1.0, 1.0): (0, 0.05),
    ("Q x 1/16", 0.25, 1.0): (0.95, 1),
    ("R x 1/16", 1.0, 0.25): (0.95, 1),
    ("R x 16", 1.0, 4.0): (0.95, 1),
}


def rows(seeds: range) -> list[Row]:
    """Return the rates of rejections."""
    record = f"{_RUNS} runs of {_STEPS} steps"
    return [
        counted(
            "pose_consistency of the EKF",
            name,
            record,
            "rejected",
            promised,
            [_report(seed, process, measured).verdict != "consistent" for seed in seeds],
        )
        for (name, process, measured), promised in _CASES.items()
    ]


def _report(seed: int, process: float, measured: float):
    traces = []
    for run in range(_RUNS):
        sim = robsim.Simulation(
            robot="lab",
            measure=True,
            boundary="unlimited",
            control=robsim.DriveAround(),
            process_noise=_NOISE,
            seed=_RUNS * seed + run,
        )
        sim.estimate_state = reference.ExtendedKalmanFilter(
            sim.model,
            process_sigma=process * _NOISE.sigma,
            measurement_sigma=[measured * sigma for sigma in (0.3, 0.3, 0.05)],
        )
        traces.append(sim.run(_STEPS))
    return robsim.pose_consistency(traces)
