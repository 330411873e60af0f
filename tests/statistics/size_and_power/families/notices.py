"""The notice that a robot is measured driving backwards: its frames may be mirrored, or BGR."""

import numpy as np

import robsim
from robsim.simulation._outside.mirrored import drives_backwards
from size_and_power.row import Row, counted

SHARE = 0.3

_STEPS = 100
_SIGMA = np.array([1.0, 1.0, 0.1])  # of a measured pose (px, px, rad)


def rows(seeds: range) -> list[Row]:
    """Return how often the notice is given."""
    found = []
    controllers = {
        "DriveAround": robsim.DriveAround,
        "GoToPoint": lambda: robsim.GoToPoint(200, 900),
        "Spin": robsim.Spin,
    }
    for name, make in controllers.items():
        runs = [_run(make(), seed) for seed in seeds]
        given = [drives_backwards(u, poses) for u, poses in runs]
        texts = (f"{_STEPS} steps", "given")
        found.append(counted("drives backwards", f"{name}, right", *texts, (0, 0.005), given))
        if name == "DriveAround":
            given = [drives_backwards(u, np.add(poses, (0, 0, np.pi))) for u, poses in runs]
            found.append(counted("drives backwards", f"{name}, BGR", *texts, (0.8, 1), given))
    return found


def _run(control, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    sim = robsim.Simulation(
        robot="lab", control=control, start="random", measure=True, resolution=(400, 400), seed=seed
    )
    trace = sim.run(_STEPS)
    return trace.u, trace.pose_true + rng.normal(size=(_STEPS, 3)) * _SIGMA
