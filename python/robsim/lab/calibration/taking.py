"""The choice of useful pictures of a board, and the lens from these pictures."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robsim.lab.calibration.lens import FEWEST, View, lens_of_views
from robsim.lab.calibration.lens_report import LensCalibration, coverage_of, parts_without
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.vision.imaging.video import load_opencv

_STILL = 1.0  # px, from one look to the next
_NEW = 0.06  # of the diagonal: how far the corners are from those of all other pictures


class BoardTaker:
    """Chooses useful frames of a board from a live camera, of a size in px."""

    def __init__(self, board: Chessboard | Charuco, size: tuple[int, int]) -> None:
        self.board, self._size = board, size
        self._last: Corners | None = None
        self._kept: list[Corners] = []

    def takes(self, image: Any) -> bool:
        """Return whether the board in a frame rests in a new position."""
        return self.look(image) is not None

    def look(self, image: Any) -> Corners | None:
        """Return the corners of a board that rests in a new position; otherwise None."""
        corners = self.board.find(image)
        last, self._last = self._last, corners
        if corners is None or last is None or _moved(last, corners) > _STILL:
            return None
        limit = _NEW * float(np.hypot(*self._size))
        if any(_moved(other, corners) < limit for other in self._kept):
            return None
        self._kept.append(corners)
        return corners

    @property
    def empty_parts(self) -> tuple[str, ...]:
        return _empty_parts(self._kept, self._size)


def _empty_parts(seen: Iterable[Corners], size: tuple[int, int]) -> tuple[str, ...]:
    """Return the parts of pictures of a size (px) without a board; empty before the first board."""
    pixels = [one.pixels for one in seen]
    return parts_without(coverage_of(size, np.concatenate(pixels))) if pixels else ()


@dataclass(frozen=True, eq=False)
class BoardPictures:
    """The corners of a board in pictures of one size, by name, in the order of taking."""

    board: Chessboard | Charuco  # the board in the pictures
    size: tuple[int, int] = (1, 1)  # their width and height (px)
    corners: Mapping[str, Corners] = field(default_factory=dict)  # the corners in each picture

    def __len__(self) -> int:
        return len(self.corners)

    def may_show(self, board: Chessboard | Charuco) -> bool:
        """Return whether a board differs at most in the side of its squares."""
        return replace(self.board, square=board.square) == board

    def of(self, board: Chessboard | Charuco) -> BoardPictures:
        """Return the pictures for another board; ValueError if they do not show this board."""
        if board == self.board:
            return self
        if self.may_show(board):
            scale = board.square / self.board.square
            seen = {name: _resized(one, scale) for name, one in self.corners.items()}
            return replace(self, board=board, corners=seen)
        if len(self):
            raise ValueError(f"the pictures taken so far show another board: {self.remove_first}")
        return BoardPictures(board)

    def with_picture(
        self, name: str, size: tuple[int, int], corners: Corners, board: Chessboard | Charuco
    ) -> BoardPictures:
        """Add a picture, with or without found corners; ValueError for another size."""
        if len(self) and size != self.size:
            (width, height), (other_width, other_height) = self.size, size
            raise ValueError(
                f"this picture has {other_width} x {other_height} px, but the pictures of the "
                f"board have {width} x {height} px: {self.remove_first}, or take pictures of that "
                "size"
            )
        names = itertools.chain([name], (f"{name} ({n})" for n in itertools.count(2)))
        free = next(one for one in names if one not in self.corners)
        seen = {**self.corners, free: _resized(corners, self.board.square / board.square)}
        return BoardPictures(self.board, size, seen)

    def without(self, number: int) -> BoardPictures:
        """Remove a picture by its position, from 0."""
        return replace(
            self,
            corners={
                name: one for i, (name, one) in enumerate(self.corners.items()) if i != number
            },
        )

    @property
    def remove_first(self) -> str:
        """The remedy for pictures of another board or size."""
        count = len(self)
        return "remove the picture first" if count == 1 else f"remove the {count} pictures first"

    @property
    def lacking(self) -> str:
        """The number of missing pictures for a lens, as a text; empty if there are enough."""
        missing = FEWEST - len(self)
        if missing <= 0:
            return ""
        more = "a picture" if missing == 1 else f"{missing} pictures"
        return f"take {more} more of the board: {FEWEST} are required, 10 to 20 are better"

    @property
    def empty_parts(self) -> tuple[str, ...]:
        return _empty_parts(self.corners.values(), self.size)

    def lens(self) -> LensCalibration:
        """Return the lens from these pictures; ValueError if the calibration fails."""
        cv2 = load_opencv("calibrating a lens")
        views = [View(*one) for one in self.corners.items()]
        try:
            return lens_of_views(cv2, self.size, views, {})
        except (ValueError, cv2.error) as error:
            raise ValueError(
                f"the lens cannot be calibrated from these pictures: {error}"
            ) from error


def _resized(corners: Corners, scale: float) -> Corners:
    return Corners(corners.positions * scale, corners.pixels)


def _moved(one: Corners, other: Corners) -> float:
    """Return the mean distance of the corners visible in both (px)."""
    places = {
        tuple(place): pixel for place, pixel in zip(one.positions.tolist(), one.pixels, strict=True)
    }
    apart = [
        float(np.linalg.norm(places[tuple(place)] - pixel))
        for place, pixel in zip(other.positions.tolist(), other.pixels, strict=True)
        if tuple(place) in places
    ]
    return float(np.mean(apart)) if apart else float("inf")
