"""Standard errors, excitation and convergence of the model's parameters."""

import numpy as np

import robsim
from robsim.estimation import output_error, parameter_convergence
from size_and_power.trials import Row, Trials, random_of

_SHARE = 0.2
_STEPS = 400
_SIGMA = np.array([0.3, 0.3, 0.01])  # of a measured pose (px, px, rad)
_DRIVE = robsim.Scenario(robot="lab", boundary="unlimited", control=robsim.DriveAround())
_METHODS = ("instrumental_variables", "output_error")
_CONTROLS = {"Spin": robsim.Spin(), "DriveAround": robsim.DriveAround()}


def _within(trace, times):
    """Whether b1X is within so many half intervals of its true value, by method."""
    given = {}
    for method in _METHODS:
        fit = robsim.batch_estimate(trace, identify_from="measurement", method=method)
        z = (fit.batch - fit.theta_true) / fit.standard_errors
        given[method] = abs(z[0, 2]) <= times * 1.96
    return given


def _within_of_independent(trace):
    """The same, on poses with independent errors."""
    poses = trace.pose_true + random_of(trace).normal(size=(len(trace), 3)) * _SIGMA
    again = _DRIVE.replace(control=robsim.Replay(trace.u))
    sim = robsim.Simulation(again, measure=lambda step: poses[step.k])
    return _within(sim.run(len(trace)), 1)


def _within_of_camera(trace):
    return _within(trace, 4)


_DELAY = 1.4  # steps


def _delay_within(trace):
    """Whether the delay that was fitted is within its half interval of the true one."""
    poses = trace.pose_true + random_of(trace).normal(size=(len(trace), 3)) * _SIGMA
    fit = output_error(poses, trace.u, motor_delay="fit")
    return {"within": abs(fit.motor_delay - _DELAY) <= 1.96 * fit.motor_delay_error}


def _interval(errors, times, promised):
    answer, record = f"b1X within {times} x 1.96 of them", f"1 run of {_STEPS} steps"
    verdicts = {method: f"standard error, {method.replace('_', ' ')}" for method in _METHODS}
    return {
        ("", method): Row(verdict, f"errors {errors}", record, answer, promised)
        for method, verdict in verdicts.items()
    }


def _excitation(trace):
    verdict = robsim.identifiability(trace).verdict
    return {"not excited": verdict == "not excited", "well": verdict == "well"}


def _convergence(trace):
    return {"converged": parameter_convergence(trace).verdict == "converged"}


def _by_control(verdict, steps, answers):
    return {
        (control, answer): Row(verdict, control, f"1 run of {steps} steps", answer, promised)
        for control, (answer, promised) in answers.items()
    }


TRIALS = (
    Trials(
        name="independent-errors",
        scenario=_DRIVE,
        metric=_within_of_independent,
        rows=_interval("independent", 1, (0.9, 0.98)),
        steps=_STEPS,
        share=_SHARE,
    ),
    Trials(
        name="camera-errors",
        scenario=_DRIVE.replace(measure=True, headings=None),
        metric=_within_of_camera,
        rows=_interval("of a camera", 4, (0.9, 1)),
        steps=_STEPS,
        share=_SHARE,
    ),
    Trials(
        name="delay",
        scenario=_DRIVE.replace(motor_delay=_DELAY),
        metric=_delay_within,
        rows={
            ("", "within"): Row(
                "standard error, delay that was fitted",
                "errors independent",
                f"1 run of {_STEPS} steps",
                "delay within 1 x 1.96 of it",
                (0.9, 0.98),
            )
        },
        steps=_STEPS,
        share=_SHARE,
    ),
    Trials(
        name="excitation",
        scenario=_DRIVE.replace(estimate_parameters=True),
        vary={"control": _CONTROLS},
        metric=_excitation,
        rows=_by_control(
            "excitation",
            1200,
            {"Spin": ("not excited", (0.99, 1)), "DriveAround": ("well", (0.99, 1))},
        ),
        steps=1200,
        share=_SHARE,
    ),
    Trials(
        name="convergence",
        scenario=_DRIVE.replace(estimate_parameters=True),
        vary={"control": _CONTROLS},
        metric=_convergence,
        rows=_by_control(
            "convergence",
            300,
            {"Spin": ("converged", (0, 0.01)), "DriveAround": ("converged", (0.99, 1))},
        ),
        steps=300,
        share=_SHARE,
    ),
)
