"""The notice that a robot is measured driving backwards: its frames may be mirrored, or BGR."""

import numpy as np

import robsim
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


TRIALS = (
    Trials(
        name="drives-backwards",
        scenario=robsim.Scenario(robot="lab", start="random", measure=True, resolution=(400, 400)),
        vary={
            "control": {
                "DriveAround": robsim.DriveAround(),
                "GoToPoint": _target,
                "Spin": robsim.Spin(),
            }
        },
        metric=_notices,
        rows={
            key: Row("drives backwards", ", ".join(key), f"{_STEPS} steps", "given", promised)
            for key, promised in _PROMISED.items()
        },
        steps=_STEPS,
        share=0.3,
    ),
)
