"""The warning that the markers are too small in the frames."""

from __future__ import annotations

from robsim._base.warn import warn_user
from robsim._core import Frame, MarkerLayout, small_markers_remark


class SmallMarkersWarning(UserWarning):
    """The markers are too small in the frames for poses that can be trusted.

    Attributes
    ----------
    width : float
        Width of the smaller marker (px of the frame).
    """

    def __init__(self, message: str, width: float) -> None:
        super().__init__(message, width)
        self.width = width

    def __str__(self) -> str:
        return str(self.args[0])


def warn_of_small_markers(markers: MarkerLayout, frame: Frame) -> None:
    """Warn the caller of robsim if the markers are too small in a frame.

    Parameters
    ----------
    markers : MarkerLayout
        The markers that are looked for.
    frame : Frame
        A frame of the camera.
    """
    if (remark := small_markers_remark(markers, frame)) is not None:
        warn_user(SmallMarkersWarning(remark, markers.width_in(frame)))
