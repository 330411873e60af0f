"""JPEG images that came over a line: whole ones only."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import is_whole_jpeg

_MOST_PIXELS = 64_000_000


def decoded(data: bytes) -> Any:
    """Return the pixels of a JPEG image, array (H, W, 3); None if it is torn or none.

    Decoders fill up what is missing: Pillow if there is an end marker, FFmpeg and OpenCV always.
    """
    if not is_whole_jpeg(data):
        return None
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG",)) as image:
            if image.width * image.height > _MOST_PIXELS:
                return None
            return np.asarray(image if image.mode == "RGB" else image.convert("RGB"))
    except (OSError, ValueError, SyntaxError):
        return None
