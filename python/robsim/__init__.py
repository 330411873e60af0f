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
    classify,
    color_histograms,
    find_blobs,
    least_squares,
    locate,
    regression_samples,
    rgb_to_yuv,
    wrap_angle,
)
from robsim.clip import Clip
from robsim.color_picture import paint_classes
from robsim.color_score import ColorScore, score_color
from robsim.colors import color_text, load_colors, save_colors
from robsim.controllers import FollowPath, GoToPoint
from robsim.excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.four_points import plane_map_from_points
from robsim.identification import BatchEstimate, batch_estimate
from robsim.path_score import PathScore, score_path
from robsim.pictures import read_picture, write_picture
from robsim.recordings import Recording
from robsim.robots import (
    RobotDefinition,
    add_robot,
    check_colors,
    chosen_robot,
    load_robot,
    remove_robot,
    reset_robot,
    robot_from_picture,
    robot_names,
    rotate_robot,
    save_robot,
    use_robot,
)
from robsim.scene import draw_red_square
from robsim.shipped import copy_notebooks
from robsim.simulation import Simulation
from robsim.trace import PARAMETER_NAMES, RunInfo, Trace, TrackingStatistics
from robsim.video import VideoWriter, write_video

if TYPE_CHECKING:
    from robsim.plotting import (
        annotated_frames,
        draw_overlay,
        play,
        plot_batch,
        plot_color_histograms,
        plot_frame,
        plot_parameters,
        plot_robot,
        plot_traces,
    )

__version__ = _version("robsim")

__all__ = [
    "PARAMETER_NAMES",
    "BatchEstimate",
    "Blob",
    "Chirp",
    "Clip",
    "ColorClass",
    "ColorScore",
    "Controller",
    "DriveAround",
    "Estimate",
    "FollowPath",
    "Frame",
    "GoToPoint",
    "LeastSquaresFit",
    "Locator",
    "Measurement",
    "MultiSine",
    "PathScore",
    "PlaneMap",
    "PseudoRandomBinary",
    "Recording",
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
    "VideoWriter",
    "VisualNoise",
    "WorldState",
    "__version__",
    "add_robot",
    "annotated_frames",
    "batch_estimate",
    "check_colors",
    "chosen_robot",
    "classify",
    "color_histograms",
    "color_text",
    "copy_notebooks",
    "draw_overlay",
    "draw_red_square",
    "find_blobs",
    "least_squares",
    "load_colors",
    "load_robot",
    "locate",
    "paint_classes",
    "plane_map_from_points",
    "play",
    "plot_batch",
    "plot_color_histograms",
    "plot_frame",
    "plot_parameters",
    "plot_robot",
    "plot_traces",
    "read_picture",
    "regression_samples",
    "remove_robot",
    "reset_robot",
    "rgb_to_yuv",
    "robot_from_picture",
    "robot_names",
    "rotate_robot",
    "save_colors",
    "save_robot",
    "score_color",
    "score_path",
    "use_robot",
    "wrap_angle",
    "write_picture",
    "write_video",
]


_DRAWING = {"annotated_frames", "draw_overlay", "play"} | {
    name for name in __all__ if name.startswith("plot_")
}


def __getattr__(name: str) -> Any:
    # Drawing is loaded when it is asked for: `import robsim` needs no matplotlib.
    if name in _DRAWING:
        from robsim import plotting

        return getattr(plotting, name)
    raise AttributeError(f"module 'robsim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
