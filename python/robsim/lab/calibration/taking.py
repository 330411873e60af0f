"""Pictures of a board that are worth taking: it stands still in them, somewhere new."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.pattern import Corners

_STILL = 1.0  # px, from one look to the next
_NEW = 0.06  # of the diagonal: how far the corners are from those of all other pictures
_WORDS = (
    ("top left", "top", "top right"),
    ("left", "centre", "right"),
    ("bottom left", "bottom", "bottom right"),
)


class BoardTaker:
    """Decides which frames of a live camera are worth keeping.

    Parameters
    ----------
    board : Chessboard or Charuco
        What is held in front of the camera.
    size : tuple of int
        Width and height of the frames (px).

    Attributes
    ----------
    board : Chessboard or Charuco
        As given.
    """

    def __init__(self, board: Chessboard | Charuco, size: tuple[int, int]) -> None:
        self.board, self._size = board, size
        self._last: Corners | None = None
        self._kept: list[Corners] = []

    def takes(self, image: Any) -> bool:
        """Return whether the board stands still in a frame, in a place that is new."""
        return self.look(image) is not None

    def look(self, image: Any) -> Corners | None:
        """Return the corners of a board that stands still in a frame, in a place that is new."""
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
    def empty_parts(self) -> list[str]:
        return empty_parts(self._kept, self._size)


def is_resized(one: Chessboard | Charuco, other: Chessboard | Charuco) -> bool:
    return one != other and replace(one, square=other.square) == other


def resized(corners: Corners, one: Chessboard | Charuco, other: Chessboard | Charuco) -> Corners:
    return Corners(corners.positions * (other.square / one.square), corners.pixels)


def empty_parts(seen: Sequence[Corners], size: tuple[int, int]) -> list[str]:
    """Return the parts of pictures of a size (px) that no board has reached; none of no boards."""
    if not seen:
        return []
    pixels = np.concatenate([one.pixels for one in seen])
    cells: Floats = np.clip(np.floor(4 * pixels / size), 0, 3)
    thirds = np.array([0, 1, 1, 2])[cells.astype(int)]
    reached = {(int(row), int(column)) for column, row in thirds}
    return [_WORDS[i][j] for i in range(3) for j in range(3) if (i, j) not in reached]


def _moved(one: Corners, other: Corners) -> float:
    """Return how far the corners that both show are apart (px), on the mean."""
    places = {
        tuple(place): pixel for place, pixel in zip(one.positions.tolist(), one.pixels, strict=True)
    }
    apart = [
        float(np.linalg.norm(places[tuple(place)] - pixel))
        for place, pixel in zip(other.positions.tolist(), other.pixels, strict=True)
        if tuple(place) in places
    ]
    return float(np.mean(apart)) if apart else float("inf")
