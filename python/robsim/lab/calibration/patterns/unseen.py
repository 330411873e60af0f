"""`why_unseen`: the likely reason why a picture shows no whole board."""

from __future__ import annotations

from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.lab.calibration.patterns.boards import (
    Charuco,
    Chessboard,
    find_part,
    has_squares,
    reduced,
)
from robsim.lab.calibration.patterns.pattern import PURPOSE, Pixels, gray_of
from robsim.vision.imaging.video import load_opencv

_SMALL = 8.0  # px of a square.
_EDGE = 1.5  # squares between the corners and the picture's edge.
_WHITE = 250  # level of glare.
_SOFT = 3.4  # px of the slope of a blurred edge.


def why_unseen(board: Chessboard | Charuco, image: Pixels) -> str:
    """Return in a few words why an RGB picture does not show a board that `board.find` missed."""
    if isinstance(board, Charuco) and board.find(np.ascontiguousarray(image[:, ::-1])):
        return "mirrored"
    cv2 = load_opencv(PURPOSE)
    gray = gray_of(image)
    small, scale = reduced(cv2, gray)
    grid = _part(cv2, small) if isinstance(board, Chessboard) else None
    if grid is None:
        dim = np.quantile(small, 0.99) < 40
        blur = _rise(cv2, small) > _SOFT
        return "too dark" if dim else "blurred" if blur else "too few corners found"
    longer, shorter = sorted(grid.shape[:2], reverse=True)
    steps = [np.linalg.norm(np.diff(grid, axis=axis), axis=2) for axis in (0, 1)]
    side = float(min(map(np.median, steps)))
    low, high = grid.min(axis=(0, 1)), grid.max(axis=(0, 1))
    left, top = np.maximum(low - side, 0).astype(int)
    right, bottom = (high + side).astype(int)
    seen = small[top:bottom, left:right]
    if longer > max(board.columns, board.rows) or shorter > min(board.columns, board.rows):
        return f"a board of {longer} x {shorter} corners is seen"
    if side < _SMALL * scale:
        return f"too small: squares of {side / scale:.0f} px"
    if (low < _EDGE * side).any() or (high > np.array(small.shape[::-1]) - _EDGE * side).any():
        return "not whole in the picture"
    if _rise(cv2, seen) > _SOFT:
        return "blurred"
    # white over more than a square
    kernel = np.ones((int(1.2 * side),) * 2, np.uint8)
    glare = cv2.erode((seen >= _WHITE).astype(np.uint8), kernel).any()
    return "glare" if glare else "a part is covered"


def _part(cv2: Any, gray: Pixels) -> Floats | None:
    """Return the corners (R, C, 2) of a part of a chessboard, 3 x 3 or more."""
    for flags in (0, cv2.CALIB_CB_NORMALIZE_IMAGE):
        grid = find_part(cv2, gray, flags)
        if grid is not None and has_squares(cv2, gray, grid, is_part=True):
            return grid
    return None


def _rise(cv2: Any, gray: Pixels) -> float:
    """Return over how many px the sharpest edges of a picture rise."""
    levels = gray.astype(np.float32)
    slopes = np.hypot(cv2.Sobel(levels, -1, 1, 0), cv2.Sobel(levels, -1, 0, 1)) / 8
    low, high = np.quantile(gray, (0.02, 0.98))
    return float((high - low) / max(np.quantile(slopes, 0.99), 1e-3))
