"""Camera-based control of mobile robots, simulated: render, detect, measure, identify, show.

What is used first is here. The rest is one step down, by subject: `robsim.imaging`, `trace`,
`vision`, `control`, `identification`, `evaluation`, `reference`, `robots`, `simulation`,
`capture`, `calibration`, `motors`, `sessions`, `campaigns`, `grading`, `tasks`, `assignments`,
`live`, `plotting`, `gui`, `doctor`, `bench`.
"""

import importlib as _importlib
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from robsim._base.public import present as _present
from robsim._core import wrap_angle
from robsim.capture import Camera
from robsim.control import DriveAround, FollowPath, GoToPoint, Replay, Spin, score_path
from robsim.evaluation import pose_consistency, pose_errors
from robsim.identification import RecursiveLeastSquares, batch_estimate, identifiability
from robsim.imaging import Frame, GaussianNoise, Recording, UniformNoise
from robsim.robots import load_robot
from robsim.simulation import (
    Dropout,
    Estimate,
    Experiment,
    Observation,
    ParameterMismatch,
    PoseNoise,
    RobotModel,
    RobotParameters,
    Scenario,
    Simulation,
    Step,
    Unicycle,
    WheelNoise,
)
from robsim.trace import Trace
from robsim.vision import ColorClass, Measurement, find_blobs, load_colors, locate

if _TYPE_CHECKING:
    __version__: str
    from robsim import bench as bench
    from robsim import doctor as doctor
    from robsim import plotting as plotting
    from robsim import reference as reference
    from robsim.campaigns import campaign
    from robsim.doctor import check_estimator, check_parameter_estimator
    from robsim.gui import panel
    from robsim.plotting import (
        play,
        plot_batch,
        plot_errors,
        plot_frame,
        plot_parameters,
        plot_traces,
    )

__all__ = [
    "Camera",
    "ColorClass",
    "DriveAround",
    "Dropout",
    "Estimate",
    "Experiment",
    "FollowPath",
    "Frame",
    "GaussianNoise",
    "GoToPoint",
    "Measurement",
    "Observation",
    "ParameterMismatch",
    "PoseNoise",
    "Recording",
    "RecursiveLeastSquares",
    "Replay",
    "RobotModel",
    "RobotParameters",
    "Scenario",
    "Simulation",
    "Spin",
    "Step",
    "Trace",
    "Unicycle",
    "UniformNoise",
    "WheelNoise",
    "__version__",
    "batch_estimate",
    "campaign",
    "check_estimator",
    "check_parameter_estimator",
    "find_blobs",
    "identifiability",
    "load_colors",
    "load_robot",
    "locate",
    "panel",
    "play",
    "plot_batch",
    "plot_errors",
    "plot_frame",
    "plot_parameters",
    "plot_traces",
    "pose_consistency",
    "pose_errors",
    "score_path",
    "wrap_angle",
]

# Loaded when asked for: `import robsim` needs no matplotlib, and is quick.
_LATE_ROOMS = (
    *(
        "bench",
        "calibration",
        "campaigns",
        "digests",
        "doctor",
        "grading",
        "gui",
        "gym",
        "live",
        "motors",
        "plotting",
    ),
    *("assignments", "reference", "sessions", "tasks"),
)
_LATE_NAMES = {
    name: "plotting" if name.startswith("pl") else "doctor"
    for name in __all__
    if name == "play" or name.startswith(("plot_", "check_"))
} | {"campaign": "campaigns", "panel": "gui"}

_ROOMS = (
    *(
        "capture",
        "control",
        "evaluation",
        "identification",
        "imaging",
        "robots",
        "simulation",
        "trace",
    ),
    *("vision", *_LATE_ROOMS),
)

_present({**globals(), "__all__": [name for name in __all__ if name in globals()]})


def __getattr__(name: str) -> _Any:
    if name == "__version__":
        return _importlib.import_module("importlib.metadata").version("robsim")
    if name in _LATE_ROOMS:
        return _importlib.import_module(f"robsim.{name}")
    if name in _LATE_NAMES:
        return getattr(__getattr__(_LATE_NAMES[name]), name)
    message = f"module 'robsim' has no attribute {name!r}"
    if name.startswith("_"):
        raise AttributeError(message)
    from robsim._base.spelling import no_attribute, suggestion

    # These are quick to load; `plotting` would load matplotlib.
    late = map(__getattr__, ("campaigns", "gui", "reference"))
    loaded = [*late, *(globals()[room] for room in _ROOMS if room in globals())]
    for room in loaded:
        if name in room.__all__:
            raise no_attribute(f"{message}: it is {room.__name__}.{name}")
    raise no_attribute(message + suggestion(name, __all__))


def __dir__() -> list[str]:
    return sorted([*__all__, *_ROOMS])
