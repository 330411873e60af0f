"""Camera-based control of mobile robots, simulated: render, detect, measure, identify, plot.

The most used names are here. The rest is one level down, in wings: `robsim.vision`, `trace`,
`control`, `estimation`, `simulation`, `campaigns`, `plotting`; `robsim.lab` for real cameras and
motors, `robsim.teach` for tasks, checks and grading, `robsim.gui` for the panel.
"""

import importlib as _importlib
import os as _os
import sys as _sys
from _thread import RLock as _RLock
from types import ModuleType as _ModuleType
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

if _TYPE_CHECKING:
    __version__: str
    from robsim import lab as lab
    from robsim import plotting as plotting
    from robsim import teach as teach
    from robsim._core import wrap_angle as wrap_angle
    from robsim.campaigns import campaign as campaign
    from robsim.control import DriveAround as DriveAround
    from robsim.control import FollowPath as FollowPath
    from robsim.control import GoToPoint as GoToPoint
    from robsim.control import Replay as Replay
    from robsim.control import Spin as Spin
    from robsim.control import score_path as score_path
    from robsim.estimation import RecursiveLeastSquares as RecursiveLeastSquares
    from robsim.estimation import batch_estimate as batch_estimate
    from robsim.estimation import identifiability as identifiability
    from robsim.estimation import pose_consistency as pose_consistency
    from robsim.estimation import pose_errors as pose_errors
    from robsim.gui import panel as panel
    from robsim.lab import Camera as Camera
    from robsim.plotting import play as play
    from robsim.plotting import plot_batch as plot_batch
    from robsim.plotting import plot_errors as plot_errors
    from robsim.plotting import plot_frame as plot_frame
    from robsim.plotting import plot_parameters as plot_parameters
    from robsim.plotting import plot_traces as plot_traces
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
    from robsim.teach import check_estimator as check_estimator
    from robsim.teach import check_parameter_estimator as check_parameter_estimator
    from robsim.trace import Trace as Trace
    from robsim.vision import ColorClass as ColorClass
    from robsim.vision import Frame as Frame
    from robsim.vision import GaussianNoise as GaussianNoise
    from robsim.vision import Measurement as Measurement
    from robsim.vision import Recording as Recording
    from robsim.vision import UniformNoise as UniformNoise
    from robsim.vision import find_blobs as find_blobs
    from robsim.vision import load_colors as load_colors
    from robsim.vision import load_robot as load_robot
    from robsim.vision import locate as locate

#: Wings, and the names taken from each wing, load on first use, so that `import robsim` is fast.
_WINGS = {
    "vision": "ColorClass Frame GaussianNoise Measurement Recording UniformNoise find_blobs "
    "load_colors load_robot locate",
    "trace": "Trace",
    "control": "DriveAround FollowPath GoToPoint Replay Spin score_path",
    "estimation": "RecursiveLeastSquares batch_estimate identifiability pose_consistency "
    "pose_errors",
    "simulation": "Dropout Estimate Experiment Observation ParameterMismatch PoseNoise RobotModel "
    "RobotParameters Scenario Simulation Step Unicycle WheelNoise",
    "campaigns": "campaign",
    "plotting": "play plot_batch plot_errors plot_frame plot_parameters plot_traces",
    "lab": "Camera",
    "teach": "check_estimator check_parameter_estimator",
    "gui": "panel",
}
_HOMES = {name: wing for wing, names in _WINGS.items() for name in names.split()}
__all__ = sorted([*_HOMES, "__version__", "wrap_angle"])


class _Package(_ModuleType):
    """The type of the module `robsim`; Python binds each wing to the module after loading."""

    def __setattr__(self, name: str, value: _Any) -> None:
        super().__setattr__(name, value)
        # Tests may set another object instead of a wing.
        if name in _WINGS and isinstance(value, _ModuleType) and "__all__" in vars(value):
            from robsim.base.doors import present

            present(value, value.__name__)


_sys.modules[__name__].__class__ = _Package

#: Wings import one another: two threads that began with different ones would see halves of them.
_loading = _RLock()


def _begin_anew() -> None:
    """Create an unlocked lock in a forked process, because another thread may have held the old."""
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
    if name in _WINGS:
        from robsim.base.hidden_modules import check_modules

        try:
            wing = _importlib.import_module(f"robsim.{name}")
        except (ImportError, AttributeError) as error:
            check_modules(error)
            raise
        check_modules()
        return wing
    if name == "__version__":
        value = _importlib.import_module("importlib.metadata").version("robsim")
    elif name == "wrap_angle":
        value = _importlib.import_module("robsim._core").wrap_angle
    elif name in _HOMES:
        value = getattr(_loaded(_HOMES[name]), name)
    else:
        from robsim.base.doors import not_here

        raise not_here("robsim", name, __all__)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, *_WINGS])
