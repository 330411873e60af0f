"""Type, shape and size checks of frames, for videos, clips and recordings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from robsim._core import Frame
from robsim.base.text import quoted
from robsim.vision.imaging.images import Pixels, check_pixels


def check_iterable(frames: Any) -> None:
    if not isinstance(frames, Iterable):
        raise TypeError(f"frames must be an iterable of frames, got {quoted(frames)}")


def frame_pixels(name: str, frame: Frame | Pixels) -> Pixels:
    """Return the pixels of a Frame, or an image array after a check of its type and shape."""
    if isinstance(frame, Frame):
        return frame.image
    return check_pixels(name, frame, 3, "a Frame or ")


def frame_size(pixels: Pixels) -> tuple[int, int]:
    """Return the width and height of an image (px)."""
    return pixels.shape[1], pixels.shape[0]


def check_same_size(name: str, size: tuple[int, int], first: tuple[int, int]) -> None:
    if size != first:
        raise ValueError(
            f"{name} is {size[0]} x {size[1]} px, the frames before it {first[0]} x {first[1]} px"
        )
