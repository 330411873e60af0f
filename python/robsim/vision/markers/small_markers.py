"""The warning that the markers are too small in the frames for their noise."""

from __future__ import annotations

from robsim._core import (
    Frame,
    MarkerLayout,
    expected_signal_to_noise,
    frame_noise,
    small_markers_remark,
    trusted_width,
)
from robsim.base.warn import warn_user


class SmallMarkersWarning(UserWarning):
    """The markers are too small in the frames for poses that can be trusted at their noise.

    Attributes
    ----------
    width : float
        Width of the smaller marker: the side of a square of its area (px of the frame).
    noise : float
        Standard deviation of the noise of a channel (grey levels): that of the simulated camera,
        or what a frame shows.
    """

    def __init__(self, message: str, width: float, noise: float) -> None:
        super().__init__(message, width, noise)
        self.width = width
        self.noise = noise

    @property
    def signal_to_noise(self) -> float:
        """The figure to be expected of them in good light; poses can be trusted from 4 on."""
        return expected_signal_to_noise(self.width, self.noise)

    @property
    def trusted_width(self) -> float:
        """The width from which poses can be trusted at this noise (px of the frame)."""
        return trusted_width(self.noise)

    def __str__(self) -> str:
        return str(self.args[0])


def warn_of_small_markers(markers: MarkerLayout, frame: Frame, noise: float | None) -> None:
    """Warn the caller of robsim if the markers are too small in a frame.

    Parameters
    ----------
    markers : MarkerLayout
        The markers that are looked for.
    frame : Frame
        A frame of the camera.
    noise : float or None
        Standard deviation of its noise (grey levels); None = to be measured in it.
    """
    width = markers.width_in(frame)
    known = frame_noise(frame) if noise is None else noise
    if (remark := small_markers_remark(width, known)) is not None:
        warn_user(SmallMarkersWarning(remark, width, known))
