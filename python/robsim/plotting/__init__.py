"""Figures of a run, of its reports, of frames, robots and colours; and clips for notebooks.

A colour has the same meaning in all figures. Positions are in work-area pixels with the y axis
downwards, as the camera sees the area; angles are in degrees.
"""

from robsim._base.public import present as _present
from robsim.plotting._batch import plot_batch
from robsim.plotting._colors import plot_color_histograms
from robsim.plotting._consistency import plot_consistency
from robsim.plotting._ellipses import plot_ellipses
from robsim.plotting._errors import plot_errors
from robsim.plotting._frame import plot_frame
from robsim.plotting._overlay import draw_overlay
from robsim.plotting._parameters import plot_parameters
from robsim.plotting._replay import annotated_frames, play
from robsim.plotting._robot import plot_robot
from robsim.plotting._traces import plot_traces

__all__ = [
    "annotated_frames",
    "draw_overlay",
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
]

_present(globals())
