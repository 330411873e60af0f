"""Camera-based control of mobile robots, simulated: render, detect, measure, identify, show."""

from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from robsim._core import (
    Blob,
    ColorClass,
    Controller,
    DriveAround,
    Estimate,
    Frame,
    LeastSquaresFit,
    Locator,
    Measurement,
    PlaneMap,
    RecursiveLeastSquares,
    Renderer,
    RobotModel,
    RobotParameters,
    Sample,
    Spin,
    Step,
    Unicycle,
    VisualNoise,
    WorldState,
    find_blobs,
    least_squares,
    locate,
    regression_samples,
    rgb_to_yuv,
    wrap_angle,
)
from robsim.colors import load_colors
from robsim.identification import BatchEstimate, batch_estimate
from robsim.pictures import read_picture, write_picture
from robsim.robots import RobotDefinition, load_robot, robot_names
from robsim.scene import draw_red_square
from robsim.simulation import Simulation
from robsim.trace import PARAMETER_NAMES, RunInfo, Trace, TrackingStatistics

if TYPE_CHECKING:
    from robsim.plotting import plot_batch, plot_frame, plot_parameters, plot_traces

__version__ = _version("robsim")

__all__ = [
    "PARAMETER_NAMES",
    "BatchEstimate",
    "Blob",
    "ColorClass",
    "Controller",
    "DriveAround",
    "Estimate",
    "Frame",
    "LeastSquaresFit",
    "Locator",
    "Measurement",
    "PlaneMap",
    "RecursiveLeastSquares",
    "Renderer",
    "RobotDefinition",
    "RobotModel",
    "RobotParameters",
    "RunInfo",
    "Sample",
    "Simulation",
    "Spin",
    "Step",
    "Trace",
    "TrackingStatistics",
    "Unicycle",
    "VisualNoise",
    "WorldState",
    "__version__",
    "batch_estimate",
    "draw_red_square",
    "find_blobs",
    "least_squares",
    "load_colors",
    "load_robot",
    "locate",
    "plot_batch",
    "plot_frame",
    "plot_parameters",
    "plot_traces",
    "read_picture",
    "regression_samples",
    "rgb_to_yuv",
    "robot_names",
    "wrap_angle",
    "write_picture",
]


def __getattr__(name: str) -> Any:
    # Drawing is loaded when it is asked for: `import robsim` needs no matplotlib.
    if name in __all__ and name.startswith("plot_"):
        from robsim import plotting

        return getattr(plotting, name)
    raise AttributeError(f"module 'robsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
