"""Floor sheets in a picture; the size of their marks may be measured later."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim.lab.calibration.floor import calibrate_floor_by_corners
from robsim.lab.calibration.floor_report import FloorCalibration
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet, find_sheets
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.images import Pixels, frame_size


@dataclass(frozen=True)
class SeenSheets:
    """The floor sheets in a picture."""

    size: tuple[int, int]  # the picture's (px)
    mark: float  # side of a mark, the scale of the corners (mm)
    # by the number of the sheet
    corners: dict[int, Corners] = field(default_factory=dict, repr=False)
    # where the cross of a sheet is on the floor (mm), if it was measured
    places: dict[int, tuple[float | None, float | None]] = field(default_factory=dict)

    @classmethod
    def of(cls, image: Pixels, mark: float) -> SeenSheets:
        """Find the sheets in a picture; `mark` is the side of their marks (mm)."""
        return cls(frame_size(image), mark, find_sheets(image, mark))

    def with_mark(self, mark: float) -> SeenSheets:
        """Return the same sheets with another side of the marks (mm)."""
        if mark == self.mark:
            return self
        corners = {
            number: _resized(number, one, self.mark, mark) for number, one in self.corners.items()
        }
        return replace(self, mark=mark, corners=corners)

    def floor(self, **options: Any) -> FloorCalibration:
        """Return the calibration by at least one sheet; options as for `calibrate_floor`."""
        where = {
            number: (x, y)
            for number, (x, y) in self.places.items()
            if number in self.corners and x is not None and y is not None
        }
        return calibrate_floor_by_corners(
            self.corners, self.size, mark=self.mark, places=where, **options
        )


def _resized(number: int, seen: Corners, before: float, mark: float) -> Corners:
    """Return the corners of a sheet with another side of the marks."""
    old, new = (
        np.concatenate([*FloorSheet(number, side).corners().values()]) for side in (before, mark)
    )
    nearest = np.linalg.norm(seen.positions[:, None] - old, axis=2).argmin(axis=1)
    return Corners(new[nearest], seen.pixels)
