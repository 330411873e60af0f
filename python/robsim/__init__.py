"""Camera-based control of mobile robots, simulated: render, detect, measure, identify, show.

What is used first is here. The rest is one step down, by subject: `robsim.imaging`, `trace`,
`vision`, `control`, `identification`, `evaluation`, `reference`, `robots`, `simulation`,
`capture`, `calibration`, `motors`, `sessions`, `campaigns`, `grading`, `tasks`, `assignments`,
`live`, `plotting`, `gui`, `doctor`.
"""

import importlib as _importlib
import os as _os
from _thread import RLock as _RLock
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any
from typing import NoReturn as _NoReturn

if _TYPE_CHECKING:
    __version__: str
    from robsim import doctor as doctor
    from robsim import plotting as plotting
    from robsim import reference as reference
    from robsim._core import wrap_angle as wrap_angle
    from robsim.campaigns import campaign as campaign
    from robsim.capture import Camera as Camera
    from robsim.control import DriveAround as DriveAround
    from robsim.control import FollowPath as FollowPath
    from robsim.control import GoToPoint as GoToPoint
    from robsim.control import Replay as Replay
    from robsim.control import Spin as Spin
    from robsim.control import score_path as score_path
    from robsim.doctor import check_estimator as check_estimator
    from robsim.doctor import check_parameter_estimator as check_parameter_estimator
    from robsim.evaluation import pose_consistency as pose_consistency
    from robsim.evaluation import pose_errors as pose_errors
    from robsim.gui import panel as panel
    from robsim.identification import RecursiveLeastSquares as RecursiveLeastSquares
    from robsim.identification import batch_estimate as batch_estimate
    from robsim.identification import identifiability as identifiability
    from robsim.imaging import Frame as Frame
    from robsim.imaging import GaussianNoise as GaussianNoise
    from robsim.imaging import Recording as Recording
    from robsim.imaging import UniformNoise as UniformNoise
    from robsim.plotting import play as play
    from robsim.plotting import plot_batch as plot_batch
    from robsim.plotting import plot_errors as plot_errors
    from robsim.plotting import plot_frame as plot_frame
    from robsim.plotting import plot_parameters as plot_parameters
    from robsim.plotting import plot_traces as plot_traces
    from robsim.robots import load_robot as load_robot
    from robsim.simulation import Dropout as Dropout
    from robsim.simulation import Estimate as Estimate
    from robsim.simulation import Experiment as Experiment
    from robsim.simulation import Observation as Observation
    from robsim.simulation import ParameterMismatch as ParameterMismatch
    from robsim.simulation import PoseNoise as PoseNoise
    from robsim.simulation import RobotModel as RobotModel
    from robsim.simulation import RobotParameters as RobotParameters
    from robsim.simulation import Scenario as Scenario
    from robsim.simulation import Simulation as Simulation
    from robsim.simulation import Step as Step
    from robsim.simulation import Unicycle as Unicycle
    from robsim.simulation import WheelNoise as WheelNoise
    from robsim.trace import Trace as Trace
    from robsim.vision import ColorClass as ColorClass
    from robsim.vision import Measurement as Measurement
    from robsim.vision import find_blobs as find_blobs
    from robsim.vision import load_colors as load_colors
    from robsim.vision import locate as locate

#: Everything is loaded when it is asked for, so that `import robsim` takes no time: the rooms, and
#: the names of each that are here, too.
_ROOMS = {
    "assignments": "",
    "calibration": "",
    "campaigns": "campaign",
    "capture": "Camera",
    "control": "DriveAround FollowPath GoToPoint Replay Spin score_path",
    "doctor": "check_estimator check_parameter_estimator",
    "evaluation": "pose_consistency pose_errors",
    "grading": "",
    "gui": "panel",
    "gym": "",
    "identification": "RecursiveLeastSquares batch_estimate identifiability",
    "imaging": "Frame GaussianNoise Recording UniformNoise",
    "live": "",
    "motors": "",
    "plotting": "play plot_batch plot_errors plot_frame plot_parameters plot_traces",
    "reference": "",
    "robots": "load_robot",
    "sessions": "",
    "simulation": "Dropout Estimate Experiment Observation ParameterMismatch PoseNoise RobotModel "
    "RobotParameters Scenario Simulation Step Unicycle WheelNoise",
    "tasks": "",
    "trace": "Trace",
    "vision": "ColorClass Measurement find_blobs load_colors locate",
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names.split()}
__all__ = sorted([*_HOMES, "__version__", "wrap_angle"])

#: Rooms import one another: two threads that began with different ones would see halves of them.
_loading = _RLock()


def _begin_anew() -> None:
    """Have a lock that nobody holds, in a process forked while another thread had it."""
    global _loading
    _loading = _RLock()


if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_begin_anew)


def __getattr__(name: str) -> _Any:
    if name.startswith("_") and name != "__version__":
        raise AttributeError(f"module 'robsim' has no attribute {name!r}")
    with _loading:
        return _loaded(name)


def _loaded(name: str) -> _Any:
    if name in _ROOMS:
        return _importlib.import_module(f"robsim.{name}")
    if name == "__version__":
        value = _importlib.import_module("importlib.metadata").version("robsim")
    elif name == "wrap_angle":
        value = _importlib.import_module("robsim._core").wrap_angle
    elif name in _HOMES:
        value = getattr(_loaded(_HOMES[name]), name)
    else:
        _refuse(name)
    globals()[name] = value
    return value


def _refuse(name: str) -> _NoReturn:
    """Raise AttributeError with the room that has a name, or the name that was meant."""
    from robsim._base.spelling import no_attribute, suggestion

    message = f"module 'robsim' has no attribute {name!r}"
    for room in sorted({*_ROOMS} - {"gym", "plotting"}):  # those load what not everybody has
        if name in (module := _loaded(room)).__all__:
            raise no_attribute(f"{message}: it is {module.__name__}.{name}")
    raise no_attribute(message + suggestion(name, __all__))


def __dir__() -> list[str]:
    return sorted([*__all__, *_ROOMS])
