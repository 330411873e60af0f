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
from robsim.chi_square import chi_square_band
from robsim.clip import Clip
from robsim.color_picture import paint_classes
from robsim.color_score import ColorScore, score_color
from robsim.colors import color_text, load_colors, save_colors
from robsim.consistency import (
    ConsistencyReport,
    nees,
    nees_report,
    nis,
    nis_report,
    pose_consistency,
)
from robsim.controllers import FollowPath, GoToPoint
from robsim.convergence import ConvergenceReport, convergence_time, parameter_convergence
from robsim.cramer_rao import (
    cramer_rao_bound,
    parameter_bounds,
    pose_bounds,
    posterior_cramer_rao_bound,
)
from robsim.doctor import Checkup, check_estimator, check_parameter_estimator
from robsim.excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.fits import ModelFit, instrumental_variables, output_error
from robsim.four_points import plane_map_from_points
from robsim.identifiability import Identifiability, check_excitation
from robsim.identification import BatchEstimate, batch_estimate
from robsim.metrics import ErrorReport, error_report, pose_errors, wrapped_error
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
from robsim.samples import Samples, samples_of
from robsim.scene import draw_red_square
from robsim.shipped import copy_notebooks
from robsim.simulation import Simulation
from robsim.trace import PARAMETER_NAMES, RunInfo, Trace, TrackingStatistics
from robsim.video import VideoWriter, write_video
from robsim.whiteness import WhitenessReport, whiteness_report

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
    "Checkup",
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
    "Locator",
    "Measurement",
    "ModelFit",
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
    "Samples",
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
    "check_excitation",
    "check_parameter_estimator",
    "chi_square_band",
    "chosen_robot",
    "classify",
    "color_histograms",
    "color_text",
    "convergence_time",
    "copy_notebooks",
    "cramer_rao_bound",
    "draw_overlay",
    "draw_red_square",
    "error_report",
    "find_blobs",
    "instrumental_variables",
    "least_squares",
    "load_colors",
    "load_robot",
    "locate",
    "nees",
    "nees_report",
    "nis",
    "nis_report",
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
    "read_picture",
    "regression_samples",
    "remove_robot",
    "reset_robot",
    "rgb_to_yuv",
    "robot_from_picture",
    "robot_names",
    "rotate_robot",
    "samples_of",
    "save_colors",
    "save_robot",
    "score_color",
    "score_path",
    "use_robot",
    "whiteness_report",
    "wrap_angle",
    "wrapped_error",
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
