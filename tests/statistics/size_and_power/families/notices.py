"""Notices: a robot that drives backwards, headings in degrees, few steps that make an error."""

import warnings

import numpy as np

import robsim
from robsim.estimation import estimation_errors, reference
from robsim.simulation.mirrored_frames import drives_backwards
from size_and_power.trials import Row, Trials, random_of

_STEPS = 100
_SIGMA = np.array([1.0, 1.0, 0.1])  # of a measured pose (px, px, rad)

_PROMISED = {
    ("DriveAround", "right"): (0, 0.005),
    ("DriveAround", "BGR"): (0.8, 1),
    ("GoToPoint", "right"): (0, 0.005),
    ("Spin", "right"): (0, 0.005),
}


def _notices(trace):
    poses = trace.pose_true + random_of(trace).normal(size=(len(trace), 3)) * _SIGMA
    turned = np.add(poses, (0, 0, np.pi))
    return {
        "right": drives_backwards(trace.u, poses),
        "BGR": drives_backwards(trace.u, turned),
    }


def _target():
    return robsim.GoToPoint(200, 900)


_CONTROLS = {
    "DriveAround": robsim.DriveAround(),
    "GoToPoint": _target,
    "Spin": robsim.Spin(),
}


def _warns(trace, headings):
    """Whether a run that measures these headings warns of degrees."""
    poses = np.column_stack((trace.pose_true[:, :2], headings))
    sim = robsim.Simulation(control=robsim.Replay(trace.u), measure=lambda step: poses[step.k])
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        sim.run(len(poses))
    return any("degrees" in str(one.message) for one in given)


def _degrees(trace):
    headings = trace.pose_true[:, 2] + random_of(trace).normal(size=len(trace)) * _SIGMA[2]
    forms = {
        "rad": headings,
        "a turn of rad": headings % (2 * np.pi),
        "unwrapped": np.unwrap(headings),
        "degrees": np.rad2deg(headings),
    }
    return {name: _warns(trace, form) for name, form in forms.items()}


_OFF = 3  # steps


def _few_steps(trace):
    poses = trace.pose_estimated.copy()
    answers = {"right": estimation_errors(poses, trace.pose_true).few_steps.any()}
    poses[:_OFF, :2] += 50.0
    few = estimation_errors(poses, trace.pose_true).few_steps[0]
    return answers | {f"{_OFF} steps off": few[:_OFF].all() and few.sum() < 2 * _OFF}


TRIALS = (
    Trials(
        name="drives-backwards",
        scenario=robsim.Scenario(robot="lab", start="random", measure=True, resolution=(400, 400)),
        vary={"control": _CONTROLS},
        metric=_notices,
        rows={
            key: Row("drives backwards", ", ".join(key), f"{_STEPS} steps", "given", promised)
            for key, promised in _PROMISED.items()
        },
        steps=_STEPS,
        share=0.3,
    ),
    Trials(
        name="degrees",
        scenario=robsim.Scenario(start="random", measure=True, resolution=(400, 400)),
        vary={"control": _CONTROLS},
        metric=_degrees,
        rows={
            (control, form): Row(
                "headings in degrees", f"{control}, {form}", f"{_STEPS} steps", "given", promised
            )
            for control in _CONTROLS
            for form, promised in {
                **dict.fromkeys(("rad", "a turn of rad", "unwrapped"), (0, 0.005)),
                "degrees": (0.95, 1),
            }.items()
        },
        steps=_STEPS,
        share=0.3,
    ),
    Trials(
        name="few-steps",
        scenario=robsim.Scenario(
            control=robsim.DriveAround(),
            measure=True,
            headings=None,
            noise=robsim.GaussianNoise(5),
            resolution=(300, 300),
            boundary="unlimited",
            process_noise=robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005),
        ),
        vary={"estimate_state": {"EKF": reference.ExtendedKalmanFilter}},
        metric=_few_steps,
        rows={
            ("EKF", answer): Row(
                "few steps", f"EKF, {answer}", f"{_STEPS} steps", "named", promised
            )
            for answer, promised in {
                "right": (0, 0.05),
                f"{_OFF} steps off": (0.95, 1),
            }.items()
        },
        steps=_STEPS,
        share=0.3,
    ),
)
