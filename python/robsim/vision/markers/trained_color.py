"""The result of training a colour on several frames: its class and its drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import ColorClass
from robsim.base import report
from robsim.base.checks import Floats

_MOST_ROWS = 20  # of the table


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainedColor(report.Report):
    """A colour trained on frames: the result of `train_color` and `train_markers`.

    Attributes
    ----------
    color : ColorClass
        The class, whose ranges cover the classes of all frames.
    frames : array (N,) of int
        Numbers of the frames used for training, from 0.
    medians : array (N, 3)
        Medians of Y (the level), U and V of the colour in each frame (levels).
    margins : array (N,)
        Distance of each frame's medians to the nearest limit of the class (levels).
    shares : array (N,)
        Share of each frame's pixels in the class, 0..1.
    histograms : array (3, 256)
        Number of pixels with each value of Y, U and V, in all frames together.
    missed : int
        Frames without the colour: the robot was not found, or the colour was too weak.
    """

    color: ColorClass
    frames: NDArray[np.int64]
    medians: Floats
    margins: Floats
    shares: Floats
    histograms: NDArray[np.int64]
    missed: int = 0

    @property
    def drift(self) -> float:
        """float: range of the margin over the frames, largest minus smallest (levels)."""
        return float(np.ptp(self.margins))

    @property
    def least_margin(self) -> float:
        """float: the smallest margin of a frame (levels)."""
        return float(self.margins.min())

    @property
    def is_at_risk(self) -> bool:
        """bool: whether the same drift again would use up the margin and lose the colour."""
        return self.least_margin < self.drift

    @property
    def title(self) -> str:
        """The subject of the report: the training of a colour."""
        return "Training of a colour"

    @property
    def verdict(self) -> str | None:
        """Whether the drift of the colour leaves a margin."""
        if len(self.frames) == 1:
            return None
        return "the drift eats the margin" if self.is_at_risk else "the margin outlasts the drift"

    @property
    def quantities(self) -> tuple[report.Quantity, ...]:
        """Frames, drift, margin."""
        low, high = self.medians.min(axis=0), self.medians.max(axis=0)
        spans = [f"{a:.0f} to {b:.0f}" for a, b in zip(low, high, strict=True)]
        return (
            report.Quantity("color", "colour", self.color.name),
            report.Quantity("frames", "frames", len(self.frames)),
            report.Quantity("missed", "frames without the colour", self.missed),
            *(
                report.Quantity(key, f"{key.upper()}, darkest to brightest frame", span)
                if key == "y"
                else report.Quantity(key, f"{key.upper()}, lowest to highest", span)
                for key, span in zip("yuv", spans, strict=True)
            ),
            report.Quantity("drift", "drift of the margin", self.drift, "levels", ".0f"),
            report.Quantity("least_margin", "smallest margin", self.least_margin, "levels", ".0f"),
        )

    @property
    def tables(self) -> tuple[report.Table, ...]:
        """Level and chroma of the colour, frame by frame."""
        columns = [
            report.Column("y", "Y", format=".0f"),
            report.Column("u", "U", format=".0f"),
            report.Column("v", "V", format=".0f"),
            report.Column("margin", "margin", "levels", format=".0f"),
            report.Column("share", "in the class", format=lambda share: report.percent(share, 0)),
        ]
        values = np.column_stack((self.medians, self.margins, self.shares))
        rows = [report.Row(f"frame {self.frames[i]}", tuple(values[i])) for i in self._shown]
        return (report.Table(key="levels", columns=columns, rows=rows, row_title=self.color.name),)

    @property
    def _shown(self) -> NDArray[np.int64]:
        """The frames in the table: evenly spread, and always the frame of the smallest margin."""
        count = len(self.frames)
        some = np.linspace(0, count - 1, min(count, _MOST_ROWS)).round().astype(int)
        return np.unique([*some, int(self.margins.argmin())])

    @property
    def remarks(self) -> tuple[str, ...]:
        """A warning if the drift exceeds the margin, and a note if the table omits frames."""
        remarks = []
        if self.is_at_risk:
            worst = self.frames[self.margins.argmin()]
            remarks.append(
                f"the light moves {self.color.name} by {self.drift:.0f} levels, and in frame "
                f"{worst} it is only {self.least_margin:.0f} within the limits of its class: the "
                "same drift again would lose it. Keep the light and the exposure steady, or train "
                "on "
                "frames that cover all light conditions"
            )
        if len(self._shown) < len(self.frames):
            remarks.append(f"the table shows {len(self._shown)} of {len(self.frames)} frames")
        return tuple(remarks)
