"""Type, shape and size checks of frames, for videos, clips and recordings."""

from __future__ import annotations

import numpy as np

from robsim._core import Frame
from robsim.imaging._images import Pixels


def frame_pixels(frame: Frame | Pixels) -> Pixels:
    """Return the pixels of a Frame, or an image array after a check of its type and shape."""
    pixels = frame.image if isinstance(frame, Frame) else frame
    if not isinstance(pixels, np.ndarray):
        raise TypeError(f"frames must be Frames or arrays, got {frame!r}")
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
        raise ValueError(
            f"frames must be arrays (H, W, 3) of uint8, got {pixels.shape} of {pixels.dtype}"
        )
    return pixels


def frame_size(pixels: Pixels) -> tuple[int, int]:
    """Return the width and height of an image (px)."""
    return pixels.shape[1], pixels.shape[0]


def check_same_size(name: str, size: tuple[int, int], first: tuple[int, int]) -> None:
    """Raise ValueError if a frame has another size than the first one."""
    if size != first:
        raise ValueError(
            f"{name} is {size[0]} x {size[1]} px, the frames before it {first[0]} x {first[1]} px"
        )
