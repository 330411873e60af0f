"""Pictures of a board from a live camera: one whenever the board stands still somewhere new."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from robsim._base.checks import Floats, check_int
from robsim._base.text import listed
from robsim.calibration import Charuco, Chessboard, Corners
from robsim.cli import errors
from robsim.cli.text import about

_STILL = 1.0  # px, from one look to the next
_NEW = 0.06  # of the diagonal: how far the corners are from those of all other pictures
_PATIENCE = 60.0  # s without a new picture
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
    """

    def __init__(self, board: Chessboard | Charuco, size: tuple[int, int]) -> None:
        self._board, self._size = board, size
        self._last: Corners | None = None
        self._kept: list[Corners] = []

    def takes(self, image: Any) -> bool:
        """Return whether the board stands still in a frame, in a place that is new."""
        corners = self._board.find(image)
        last, self._last = self._last, corners
        if corners is None or last is None or _moved(last, corners) > _STILL:
            return False
        limit = _NEW * float(np.hypot(*self._size))
        if any(_moved(other, corners) < limit for other in self._kept):
            return False
        self._kept.append(corners)
        return True

    @property
    def empty_parts(self) -> list[str]:
        """Parts of the picture that no board has reached."""
        if not self._kept:
            return []
        pixels = np.concatenate([one.pixels for one in self._kept])
        cells: Floats = np.clip(np.floor(4 * pixels / self._size), 0, 3)
        thirds = np.array([0, 1, 1, 2])[cells.astype(int)]
        seen = {(int(row), int(column)) for column, row in thirds}
        return [_WORDS[i][j] for i in range(3) for j in range(3) if (i, j) not in seen]


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


def taken_pictures(
    camera: str, board: Chessboard | Charuco, count: int, keep: Path | None
) -> list[tuple[str, Any]]:
    """Return names and pictures that a live camera took, and write them to a folder.

    Raises
    ------
    OSError
        If the camera cannot be opened or read, or the board does not come.
    """
    import time

    from robsim.capture import Camera, EndOfStream
    from robsim.cli.live.sources import _source
    from robsim.imaging import save_image

    with about("--count"):
        check_int("count", count, minimum=4, maximum=200)
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
    taken: list[tuple[str, Any]] = []
    with Camera(_source(camera)) as device:
        taker = BoardTaker(board, device.size)
        errors.print_note(f"hold the board still in front of the camera: {count} times")
        since = time.monotonic()
        while len(taken) < count:
            if time.monotonic() - since > _PATIENCE:
                raise TimeoutError(
                    f"no board stood still somewhere new for {_PATIENCE:g} s: {len(taken)} of "
                    f"{count} pictures were taken"
                )
            try:
                frame = device.read()
            except EndOfStream:
                break
            if not taker.takes(frame.image):
                continue
            since = time.monotonic()
            name = f"{len(taken) + 1:02d}.png"
            taken.append((name, frame.image))
            if keep is not None:
                save_image(keep / name, frame.image)
            parts = taker.empty_parts
            where = f": still nothing at the {listed(parts)}" if parts else ": tilt it another way"
            errors.print_note(f"{len(taken)} of {count}{where if len(taken) < count else ''}")
    return taken
