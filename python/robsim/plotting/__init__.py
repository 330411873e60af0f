"""Figures of a run, of its reports, of frames, robots and colours; and clips for notebooks.

A colour has the same meaning in all figures. Positions are in work-area pixels with the y axis
downwards, as the camera sees the area; angles are in degrees.
"""

from robsim._base.public import present as _present
from robsim.plotting._charts.batch import plot_batch
from robsim.plotting._charts.campaigns import plot_campaign
from robsim.plotting._charts.color_histograms import plot_color_histograms
from robsim.plotting._charts.consistency import plot_consistency
from robsim.plotting._charts.ellipses import plot_ellipses
from robsim.plotting._charts.errors import plot_errors
from robsim.plotting._charts.parameters import plot_parameters
from robsim.plotting._charts.traces import plot_traces
from robsim.plotting._images.camera_check import plot_camera_check
from robsim.plotting._images.frame import plot_frame
from robsim.plotting._images.overlay import draw_overlay
from robsim.plotting._images.replay import annotated_frames, play
from robsim.plotting._images.robot import plot_robot
from robsim.plotting._runs.several import plot_runs

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

_present(globals())
