"""Figures of a run, of its reports, of frames, robots and colours; and clips for notebooks.

A colour has the same meaning in all figures. Positions are in work-area pixels with the y axis
downwards, as in the camera's view; angles are in degrees.
"""

from robsim.plotting.charts.batch import plot_batch
from robsim.plotting.charts.campaigns import plot_campaign
from robsim.plotting.charts.color_histograms import plot_color_histograms
from robsim.plotting.charts.ellipses import plot_consistency, plot_ellipses
from robsim.plotting.charts.errors import plot_errors
from robsim.plotting.charts.parameters import plot_parameters
from robsim.plotting.charts.traces import plot_traces
from robsim.plotting.images.camera_check import plot_camera_check
from robsim.plotting.images.frame import plot_frame
from robsim.plotting.images.overlay import draw_overlay
from robsim.plotting.images.replay import annotated_frames, play
from robsim.plotting.images.robot import plot_robot
from robsim.plotting.several import plot_runs

__all__ = [
    "annotated_frames",
    "draw_overlay",
    "play",
    "plot_batch",
    "plot_camera_check",
    "plot_campaign",
    "plot_color_histograms",
    "plot_consistency",
    "plot_ellipses",
    "plot_errors",
    "plot_frame",
    "plot_parameters",
    "plot_robot",
    "plot_runs",
    "plot_traces",
]
