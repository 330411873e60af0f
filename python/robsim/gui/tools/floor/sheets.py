"""Floor sheets in a picture, and where they lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim.base.checks import check_float
from robsim.gui.tools.floor.points import FloorDraft
from robsim.lab.calibration.floor import calibrate_floor_by_corners
from robsim.lab.calibration.floor_report import FloorCalibration
from robsim.lab.calibration.patterns.floor_sheet import FloorSheet, find_sheets
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.images import Pixels, frame_size

_MARK = 80.0  # mm, as it is printed


@dataclass(frozen=True)
class SeenSheets:
    """What a picture shows of floor sheets.

    Attributes
    ----------
    size : tuple of int
        That of the picture (px).
    mark : float
        Side of a mark by which their corners are told (mm).
    corners : mapping of int to Corners
        By the number of the sheet.
    places : mapping of int to tuple of float
        Where the cross of a sheet is on the floor (mm), if it was measured.
    """

    size: tuple[int, int]
    mark: float
    corners: dict[int, Corners] = field(default_factory=dict, repr=False)
    places: dict[int, tuple[float | None, float | None]] = field(default_factory=dict)

    def fitted(self, draft: FloorDraft, lens: Calibration | None) -> FloorCalibration:
        """Return the calibration by these sheets; ValueError if there are none."""
        if not self.corners:
            raise ValueError("press Find sheets: there are none yet")
        where = {
            number: (x, y)
            for number, (x, y) in self.places.items()
            if number in self.corners and x is not None and y is not None
        }
        return calibrate_floor_by_corners(
            self.corners,
            self.size,
            area=draft.area,
            mm_per_px=draft.mm_per_px,
            marker_height=draft.marker_height,
            lens=lens,
            mark=self.mark,
            places=where,
        )


class FloorSheets:
    """The sheets that were found last, and what was measured of them."""

    def __init__(self) -> None:
        self._seen = SeenSheets((0, 0), _MARK)

    def task(self) -> SeenSheets:
        return self._seen

    def looking(self, image: Pixels) -> Callable[[], SeenSheets | str]:
        """Return what finds the sheets in a picture, or says why there are none; any thread."""
        mark = self._seen.mark

        def find() -> SeenSheets | str:
            try:
                corners = find_sheets(image, mark)
            except ImportError as error:
                return str(error)
            if not corners:
                return (
                    "there is no floor sheet in the picture: are its marks 15 px wide at least, "
                    "sharp, and not hidden?"
                )
            return SeenSheets(frame_size(image), mark, corners)

        return find

    def take(self, found: SeenSheets) -> None:
        """Take the sheets of a picture; their marks may have been given another side since."""
        mark = self._seen.mark
        corners = _all_resized(found.corners, found.mark, mark)
        self._seen = replace(self._seen, size=found.size, corners=corners)

    def place(self, number: int, x: float | None, y: float | None) -> None:
        """Say where the cross of a sheet is on the floor (mm); None = not measured."""
        if number not in self._seen.corners:
            raise ValueError(f"there is no sheet {number} in the picture")
        self._seen = replace(self._seen, places={**self._seen.places, number: (x, y)})

    def adjust(self, mark: float) -> None:
        """Set the side of a mark (mm)."""
        mark = check_float("mark", mark, "mm", minimum=5, maximum=1000)
        corners = _all_resized(self._seen.corners, self._seen.mark, mark)
        self._seen = replace(self._seen, mark=mark, corners=corners)

    def state(self) -> dict[str, Any]:
        """Return what browsers are told."""
        seen = self._seen
        return {
            "mark": seen.mark,
            "found": [
                {
                    "number": number,
                    "place": [*seen.places.get(number, (None, None))],
                    "corners": len(one.pixels),
                }
                for number, one in sorted(seen.corners.items())
            ],
        }


def _all_resized(corners: dict[int, Corners], before: float, mark: float) -> dict[int, Corners]:
    """Return the corners of sheets, by number, whose marks have another side."""
    if before == mark:
        return corners
    return {number: _resized(number, one, before, mark) for number, one in corners.items()}


def _resized(number: int, seen: Corners, before: float, mark: float) -> Corners:
    """Return the corners of a sheet whose marks have another side."""
    old, new = (
        np.concatenate([*FloorSheet(number, side).corners().values()]) for side in (before, mark)
    )
    nearest = np.linalg.norm(seen.positions[:, None] - old, axis=2).argmin(axis=1)
    return Corners(new[nearest], seen.pixels)
