"""Pictures in and out: files, PNG bytes, sizes."""

from __future__ import annotations

import io
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

Pixels = NDArray[np.uint8]

# What Pillow raises for broken files; a bomb is a small file that claims to be a huge picture.
_BROKEN = (
    UnidentifiedImageError,
    OSError,
    SyntaxError,
    ValueError,
    Image.DecompressionBombError,
    Image.DecompressionBombWarning,
)


def read_picture(path: str | PathLike[str], *, mode: str = "RGB") -> Pixels:
    """Read an image file.

    Parameters
    ----------
    path : path
        Any file that Pillow reads.
    mode : str
        ``"RGB"`` or ``"RGBA"``.

    Returns
    -------
    array (H, W, 3) or (H, W, 4) of uint8
        The pixels.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is not a picture, or a damaged one.
    """
    with Path(path).open("rb") as file:
        try:
            with Image.open(file) as picture:
                return np.array(picture.convert(mode))
        except _BROKEN as error:
            raise ValueError(f"{path} is not a picture, or damaged: {error}") from error


def write_picture(path: str | PathLike[str], pixels: Pixels) -> None:
    """Write an image file; the ending of the name says which kind.

    Parameters
    ----------
    path : path
        The file to write, such as ``frame.png``.
    pixels : array (H, W, 3) of uint8
        RGB.
    """
    Image.fromarray(pixels).save(path)


def png_bytes(pixels: Pixels) -> bytes:
    """Return the pixels (H, W, 3) as the bytes of a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", compress_level=1)
    return buffer.getvalue()


def resized(pixels: Pixels, width: int, height: int) -> Pixels:
    """Return a picture in another size: averaged when smaller, interpolated when larger.

    Parameters
    ----------
    pixels : array (H, W, 3) or (H, W, 4) of uint8
        RGB or RGBA.
    width, height : int
        The new size (px).
    """
    if (width, height) == (pixels.shape[1], pixels.shape[0]):
        return pixels
    smaller = width <= pixels.shape[1] and height <= pixels.shape[0]
    method = Image.Resampling.BOX if smaller else Image.Resampling.BICUBIC
    return np.array(Image.fromarray(pixels).resize((width, height), method))
