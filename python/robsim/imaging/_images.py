"""Pictures in and out: files, PNG bytes, sizes."""

from __future__ import annotations

import io
import warnings
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

Pixels = NDArray[np.uint8]

_WHITE = 65535  # of a picture with 16 bits a pixel

# What Pillow says of a small file that claims to be a huge picture.
_BOMBS = (Image.DecompressionBombError, Image.DecompressionBombWarning)


def load_image(path: str | PathLike[str], *, mode: str = "RGB") -> Pixels:
    """Read an image file, turned as its camera says.

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
        If the file is not a picture, or a damaged or a huge one.
    """
    with Path(path).open("rb") as file, warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        try:
            with Image.open(file) as picture:
                upright = ImageOps.exif_transpose(picture)
                return np.array(_eight_bits(upright).convert(mode))
        except UnidentifiedImageError as error:
            raise ValueError(f"{path} is not a picture of a kind that Pillow reads") from error
        except _BOMBS as error:
            raise ValueError(f"{path} has too many pixels: {error}") from error
        except Exception as error:  # Pillow's readers raise what they like
            raise ValueError(f"{path} cannot be read as a picture: {error}") from error


def _eight_bits(picture: Image.Image) -> Image.Image:
    """Return a picture with 8 bits a channel; Pillow would cut off what is over 255."""
    if picture.mode == "F":
        raise ValueError("its pixels are fractions, save it with 8 or 16 bits")
    if not picture.mode.startswith("I"):
        return picture
    pixels = np.clip(np.asarray(picture, dtype=np.int64), 0, _WHITE)
    return Image.fromarray((pixels * 255 // _WHITE).astype(np.uint8))


def save_image(path: str | PathLike[str], pixels: Pixels) -> None:
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
