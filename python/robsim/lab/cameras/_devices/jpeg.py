"""JPEG images of cameras, whole or torn."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import is_whole_jpeg
from robsim.vision.imaging.images import MOST_PIXELS


def decoded(data: bytes) -> Any:
    """Return the pixels of a JPEG image, BGR, array (H, W, 3); None if it is torn.

    Decoders fill up missing parts: Pillow if there is an end marker, FFmpeg and OpenCV always.
    """
    return pixels(data) if is_whole_jpeg(data) else None


def pixels(data: bytes) -> Any:
    """Return the pixels of a whole image; None if Pillow cannot decode it."""
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG",)) as image:
            if image.width * image.height > MOST_PIXELS:
                return None
            rgb = image if image.mode == "RGB" else image.convert("RGB")
            flat = np.frombuffer(rgb.tobytes("raw", "BGR"), np.uint8)
            return flat.reshape(image.height, image.width, 3)
    except (OSError, ValueError, SyntaxError):
        return None
