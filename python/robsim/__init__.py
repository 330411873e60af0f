"""Camera-based control of mobile robots, simulated: render, detect, measure, identify, show."""

from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from robsim._base.shipped import copy_notebooks
from robsim._core import (
    Blob,
    ColorClass,
    Controller,
    DriveAround,
    Estimate,
    Frame,
    LeastSquaresFit,
    MarkerLayout,
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
    regression,
    rgb_to_yuv,
    wrap_angle,
)
from robsim.control._excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.control._path_following import FollowPath, GoToPoint
from robsim.control._path_score import PathScore, score_path
from robsim.doctor import CheckReport, check_estimator, check_parameter_estimator
from robsim.evaluation._chi_square import chi_square_band
from robsim.evaluation._consistency import (
    ConsistencyReport,
    nees,
    nees_consistency,
    nis,
    nis_consistency,
    pose_consistency,
)
from robsim.evaluation._cramer_rao import (
    cramer_rao_bound,
    parameter_bounds,
    pose_bounds,
    posterior_cramer_rao_bound,
)
from robsim.evaluation._errors import ErrorReport, estimation_errors, pose_errors, wrapped_error
from robsim.evaluation._whiteness import WhitenessReport, whiteness
from robsim.identification._batch import BatchEstimate, batch_estimate
from robsim.identification._convergence import (
    ConvergenceReport,
    convergence_time,
    parameter_convergence,
)
from robsim.identification._fits import ModelFit, instrumental_variables, output_error
from robsim.identification._identifiability import Identifiability, identifiability
from robsim.identification._regression import Regression, regression_of
from robsim.imaging._clip import Clip
from robsim.imaging._images import load_image, save_image
from robsim.imaging._plane_maps import plane_map_from_points
from robsim.imaging._recordings import Recording
from robsim.imaging._video import VideoWriter, save_video
from robsim.robots import (
    RobotDefinition,
    add_robot,
    check_colors,
    default_robot,
    load_robot,
    remove_robot,
    reset_default_robot,
    robot_from_picture,
    robot_names,
    rotate_robot,
    save_robot,
    set_default_robot,
)
from robsim.simulation._scene import draw_red_square
from robsim.simulation._simulation import Simulation
from robsim.trace._trace import PARAMETER_NAMES, RunInfo, Trace, TrackingStatistics
from robsim.vision._color_files import colors_to_toml, load_colors, save_colors
from robsim.vision._color_masks import paint_classes
from robsim.vision._color_score import ColorScore, score_color

if TYPE_CHECKING:
    from robsim.plotting import (
        annotated_frames,
        draw_overlay,
        play,
        plot_batch,
        plot_color_histograms,
        plot_consistency,
        plot_ellipses,
        plot_errors,
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
    "CheckReport",
    "Chirp",
    "Clip",
    "ColorClass",
    "ColorScore",
    "ConsistencyReport",
    "Controller",
    "ConvergenceReport",
    "DriveAround",
    "ErrorReport",
    "Estimate",
    "FollowPath",
    "Frame",
    "GoToPoint",
    "Identifiability",
    "LeastSquaresFit",
    "MarkerLayout",
    "Measurement",
    "ModelFit",
    "MultiSine",
    "PathScore",
    "PlaneMap",
    "PseudoRandomBinary",
    "Recording",
    "RecursiveLeastSquares",
    "Regression",
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
    "WhitenessReport",
    "WorldState",
    "__version__",
    "add_robot",
    "annotated_frames",
    "batch_estimate",
    "check_colors",
    "check_estimator",
    "check_parameter_estimator",
    "chi_square_band",
    "classify",
    "color_histograms",
    "colors_to_toml",
    "convergence_time",
    "copy_notebooks",
    "cramer_rao_bound",
    "default_robot",
    "draw_overlay",
    "draw_red_square",
    "estimation_errors",
    "find_blobs",
    "identifiability",
    "instrumental_variables",
    "least_squares",
    "load_colors",
    "load_image",
    "load_robot",
    "locate",
    "nees",
    "nees_consistency",
    "nis",
    "nis_consistency",
    "output_error",
    "paint_classes",
    "parameter_bounds",
    "parameter_convergence",
    "plane_map_from_points",
    "play",
    "plot_batch",
    "plot_color_histograms",
    "plot_consistency",
    "plot_ellipses",
    "plot_errors",
    "plot_frame",
    "plot_parameters",
    "plot_robot",
    "plot_traces",
    "pose_bounds",
    "pose_consistency",
    "pose_errors",
    "posterior_cramer_rao_bound",
    "regression",
    "regression_of",
    "remove_robot",
    "reset_default_robot",
    "rgb_to_yuv",
    "robot_from_picture",
    "robot_names",
    "rotate_robot",
    "save_colors",
    "save_image",
    "save_robot",
    "save_video",
    "score_color",
    "score_path",
    "set_default_robot",
    "whiteness",
    "wrap_angle",
    "wrapped_error",
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
