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
# Process noise in each step, and measurement noise of its middle level.
_PROCESS = np.array([0.1, 0.1, 0.005])
_LEVELS = (0.1, 1, 3)
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
    return _within(trace, 2)


_DELAY = 1.4  # steps


def _delay_within(trace):
    """Whether the delay that was fitted is within its half interval of the true one."""
    poses = trace.pose_true + random_of(trace).normal(size=(len(trace), 3)) * _SIGMA
    fit = output_error(poses, trace.u, motor_delay="fit")
    return {"within": abs(fit.motor_delay - _DELAY) <= 1.96 * fit.motor_delay_error}


def _measured(trace):
    """The run with measured poses, whose errors are independent."""
    poses = trace.pose_true + random_of(trace).normal(size=(len(trace), 3)) * _PROCESS
    groups = {name: getattr(trace, name) for name in ("pose_true", "u", "bounced")}
    return robsim.Trace(groups | {"pose_measured": poses}, trace.info)


def _contradiction(trace):
    """Whether the residuals contradict independent errors, also with lost frames."""
    seen = _measured(trace)
    poses = seen.pose_measured.copy()
    poses[random_of(trace, 1).random(len(poses)) < 0.3] = np.nan
    fits = (robsim.estimation.output_error(one, seen.u) for one in (seen.pose_measured, poses))
    p_values = [fit.whiteness_p_value for fit in fits]
    return {"all frames": p_values[0] < 0.05, "30 % lost": p_values[1] < 0.05}


def _under_process_noise(trace):
    """The errors of all parameters, over both standard errors, and the cause."""
    given = {}
    for method in _METHODS:
        fit = robsim.batch_estimate(_measured(trace), identify_from="measurement", method=method)
        for name, errors in (("z", fit.standard_errors), ("white", fit.white_noise_errors)):
            z = ((fit.batch - fit.theta_true) / errors).ravel()
            given |= {f"{method} {name} {i}": value for i, value in enumerate(z)}
        given[f"{method} told"] = fit.departure == "process noise"
    return given


def _judged(numbers):
    """Each known parameter of a run, and each run, is a trial."""
    given = {}
    for method in _METHODS:
        z, white = (
            np.array([numbers[f"{method} {name} {i}"] for i in range(15)])
            for name in ("z", "white")
        )
        given[f"{method} within"] = np.abs(z[np.isfinite(z)]) <= 1.96
        with np.errstate(invalid="ignore"):
            said = np.exp(np.nanmean(np.log(white / z), axis=0))
        true = np.exp(np.mean(np.log(np.sqrt(np.nanmean(np.square(white), axis=1)))))
        given[f"{method} n"] = (said > true / 2) & (said < true * 2)
        given[f"{method} told"] = numbers[f"{method} told"] == 1
    return given


def _rows_under_process_noise():
    answers = {
        "within": ("a parameter within 1.96 of them", (0.85, 0.99)),
        "n": ("times too small, right by a factor of 2", (0.9, 1)),
        "told": ("cause told", (0.99, 1)),
    }
    return {
        (_level(level), f"{method} {name}"): Row(
            f"standard error, {method.replace('_', ' ')}",
            f"process noise, {_level(level)}",
            "1 run of 300 steps",
            answer,
            promised,
        )
        for level in _LEVELS
        for method in _METHODS
        for name, (answer, promised) in answers.items()
    }


def _level(level):
    return f"{level * _PROCESS[0]:.2g} px"


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
        rows=_interval("of a camera", 2, (0.9, 1)),
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
        name="process-noise",
        scenario=_DRIVE,
        vary={
            "process_noise": {
                _level(level): robsim.PoseNoise.from_sigma(*level * _PROCESS) for level in _LEVELS
            }
        },
        metric=_under_process_noise,
        answers=_judged,
        rows=_rows_under_process_noise(),
        steps=300,
        share=_SHARE,
    ),
    Trials(
        name="white-residuals",
        scenario=_DRIVE,
        metric=_contradiction,
        rows={
            ("", answer): Row(
                "residuals of output error", "white", f"1 run of {steps}", "not white", (0, 0.05)
            )
            for answer, steps in (
                ("all frames", "200 steps"),
                ("30 % lost", "200 steps, 30 % missing"),
            )
        },
        steps=200,
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
