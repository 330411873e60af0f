"""Standard errors, excitation and convergence of the model's parameters."""

import numpy as np

import robsim
from robsim.identification import parameter_convergence
from size_and_power.row import Row, counted

SHARE = 0.2

_STEPS = 400
_SIGMA = np.array([0.3, 0.3, 0.01])  # of a measured pose (px, px, rad)
_DRIVE = {"robot": "lab", "boundary": "unlimited"}
_METHODS = ("instrumental_variables", "output_error")


def rows(seeds: range) -> list[Row]:
    """Return how often intervals have the true value, and how often verdicts are right."""
    return [*_intervals(seeds), *_excitation(seeds), *_convergence(seeds)]


def _intervals(seeds: range) -> list[Row]:
    found = []
    record = f"1 run of {_STEPS} steps"
    for camera, promised in ((False, (0.9, 0.98)), (True, (0.9, 1))):
        distances = {method: [] for method in _METHODS}
        for seed in seeds:
            trace = _camera_run(seed) if camera else _white_run(seed)
            for method in _METHODS:
                fit = robsim.batch_estimate(trace, identify_from="measurement", method=method)
                z = (fit.batch - fit.theta_true) / fit.standard_errors
                distances[method].append(abs(z[0, 2]))
        times = 4 if camera else 1
        errors = "of a camera" if camera else "independent"
        for method in _METHODS:
            within = [distance <= times * 1.96 for distance in distances[method]]
            name = f"standard error, {method.replace('_', ' ')}"
            answer = f"b1X within {times} x 1.96 of them"
            found.append(counted(name, f"errors {errors}", record, answer, promised, within))
    return found


def _white_run(seed: int) -> robsim.Trace:
    rng = np.random.default_rng(seed)
    path = robsim.Simulation(**_DRIVE, control=robsim.DriveAround(), seed=seed).run(_STEPS)
    poses = path.pose_true + rng.normal(size=(_STEPS, 3)) * _SIGMA
    sim = robsim.Simulation(
        **_DRIVE, control=robsim.Replay(path.u), measure=lambda step: poses[step.k], seed=seed
    )
    return sim.run(_STEPS)


def _camera_run(seed: int) -> robsim.Trace:
    sim = robsim.Simulation(
        **_DRIVE, control=robsim.DriveAround(), measure=True, headings=None, seed=seed
    )
    return sim.run(_STEPS)


def _excitation(seeds: range) -> list[Row]:
    found = []
    for control, verdict in ((robsim.Spin(), "not excited"), (robsim.DriveAround(), "well")):
        given = []
        for seed in seeds:
            sim = robsim.Simulation(
                **_DRIVE, control=control, estimate_parameters=True, seed=seed, headings=None
            )
            given.append(robsim.identifiability(sim.run(1200)).verdict == verdict)
        name = type(control).__name__
        found.append(counted("excitation", name, "1 run of 1200 steps", verdict, (0.99, 1), given))
    return found


def _convergence(seeds: range) -> list[Row]:
    found = []
    for control, promised in ((robsim.Spin(), (0, 0.01)), (robsim.DriveAround(), (0.99, 1))):
        given = []
        for seed in seeds:
            sim = robsim.Simulation(**_DRIVE, control=control, estimate_parameters=True, seed=seed)
            given.append(parameter_convergence(sim.run(300)).verdict == "converged")
        name = type(control).__name__
        found.append(
            counted("convergence", name, "1 run of 300 steps", "converged", promised, given)
        )
    return found
