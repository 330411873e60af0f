"""A sentence on the steps of a run without a detection, for ``run`` and ``track``."""

from __future__ import annotations

from collections.abc import Sequence

from robsim._core import (
    Frame,
    MarkerLayout,
    MissedDetections,
    expected_signal_to_noise,
    frame_noise,
    small_markers_remark,
    trusted_width,
)
from robsim.base.warn import warn_user

# Short reasons and their sentences; other reasons, such as "no blue blob", stay unchanged.
_WORDS = {
    "noise": "the markers do not stand out of the noise",
    "at the border": "blobs at the border of the frame only",
    "distance": "no pair of blobs at the markers' distance",
    "areas": "no pair of blobs with the markers' areas",
    "ambiguous": "two pairs of blobs that fit equally well",
    "by chance": "blobs that may fit by chance",
    "dark": "a dark picture",
    "overexposed": "an overexposed picture",
    "small markers": "markers too small for the noise of the frame",
    "shape": "blobs of other outlines than the markers",
}


def explain_missed(missed: Sequence[MissedDetections], steps: int) -> str | None:
    """Return a sentence on missed steps, their most frequent reason first; None = nothing missed.

    It has the first step missed for that reason. `steps` is the length of the run.
    """
    if not missed:
        return None
    total = sum(part.steps for part in missed)
    most = missed[0]
    share = f"in {most.steps}, " if len(missed) > 1 else ""
    return (
        f"no detection in {total} of {steps} steps: {share}first in step {most.first_k}, "
        f"{most.first.explanation}"
        + "".join(
            f"; in {part.steps}: {_WORDS.get(part.reason, part.reason)}" for part in missed[1:]
        )
    )


class SmallMarkersWarning(UserWarning):
    """Warning: the markers are too small for reliable poses at the noise of the frames.

    Attributes
    ----------
    width : float
        Width of the smaller marker: the side of a square of its area (px of the frame).
    noise : float
        Standard deviation of the noise of a channel (grey levels), from the simulated camera or
        measured in a frame.
    """

    def __init__(self, message: str, width: float, noise: float) -> None:
        super().__init__(message, width, noise)
        self.width = width
        self.noise = noise

    @property
    def signal_to_noise(self) -> float:
        """Expected signal-to-noise ratio of the markers in good light; a pose needs at least 4."""
        return expected_signal_to_noise(self.width, self.noise)

    @property
    def trusted_width(self) -> float:
        """The width from which poses are reliable at this noise (px of the frame)."""
        return trusted_width(self.noise)

    def __str__(self) -> str:
        return str(self.args[0])


def warn_of_small_markers(markers: MarkerLayout, frame: Frame, noise: float | None) -> None:
    """Warn the caller of robsim if the markers are too small in a frame.

    `noise` is its standard deviation (grey levels); None = measured in the frame.
    """
    width = markers.width_in(frame)
    known = frame_noise(frame) if noise is None else noise
    if (remark := small_markers_remark(width, known)) is not None:
        warn_user(SmallMarkersWarning(remark, width, known))
