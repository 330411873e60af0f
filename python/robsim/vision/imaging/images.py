"""Reading, writing and resizing RGB and RGBA images with Pillow."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable
from functools import cache
from itertools import product
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from robsim._core import Frame
from robsim.base.checks import check_choice
from robsim.base.files import as_path, open_file, write_whole
from robsim.base.text import cut, one_line, quoted
from robsim.base.warn import warn_user

Pixels = NDArray[np.uint8]
_WHITE = 65535  # of an image with 16 bits per pixel
_DARK = 16  # the white of 12 bits in 16 is below it
#: Limit of a picture, and of the frames of a video (px).
MOST_PIXELS = 2**26
_TILE = 512  # px
# Formats that Pillow registers but cannot decode, or leaves to other programs.
_FOREIGN = {"BUFR", "EPS", "FPX", "GRIB", "HDF5", "MIC", "MPEG", "WMF"}
HEIC = ".heic", ".heif"  # which no decoder here reads
_ORIENTATION = 0x0112  # the number of EXIF's tag


def load_image(path: str | PathLike[str], *, mode: str = "RGB") -> Pixels:
    """Read an image file in the pixel order of the sensor.

    The live frames of a camera have the same order. The EXIF orientation is ignored.

    Parameters
    ----------
    path : path
        Any file that Pillow itself reads, of at most 67 108 864 pixels, such as 8192 x 8192.
    mode : str
        ``"RGB"`` or ``"RGBA"``.

    Returns
    -------
    array (H, W, 3) or (H, W, 4) of uint8
        The pixels.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If the file is not an image, is damaged, or is too large.

    Warns
    -----
    UserWarning
        Once, if viewers rotate a picture by its EXIF orientation. If a 16-bit picture is very dark.

    Examples
    --------
    >>> robsim.vision.save_image("grey.png", np.full((4, 6, 3), 128, np.uint8))
    >>> robsim.vision.load_image("grey.png")[0, 0]
    array([128, 128, 128], dtype=uint8)
    """
    check_choice("mode", mode, ("RGB", "RGBA"))
    with open_file(as_path(path)) as file, warnings.catch_warnings():
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        return decoded(file, one_line(path), mode)


def decoded(file: BinaryIO, name: str, mode: str | None = None) -> Pixels:
    """Return the `pixels_of` a file, `name` in messages, in any thread; raises as `load_image`."""
    try:
        with Image.open(file, formats=_formats()) as image:
            if image.width * image.height > MOST_PIXELS:
                raise Image.DecompressionBombError
            is_deep = ";16" in f"{image.mode} {image.tile}"  # reading EXIF forgets it
            is_turned = image.getexif().get(_ORIENTATION, 1) != 1
            pixels = pixels_of(image, mode)
    except UnidentifiedImageError as error:
        if name.lower().endswith(HEIC):
            raise ValueError(f"{name} is a HEIC picture: export it as JPEG") from error
        raise ValueError(f"{name} is not in an image format of Pillow, such as PNG") from error
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise ValueError(f"{name} has too many pixels: at most {MOST_PIXELS} are read") from error
    except MemoryError as error:
        raise ValueError(f"{name} cannot be read: not enough memory") from error
    except Exception as error:  # Pillow's decoders raise many types
        raise ValueError(f"{name} cannot be read as an image: {cut(error)}") from error
    if is_turned:
        tell_of_turn()
    if is_deep and 0 < pixels[..., :3].max() < _DARK:
        warn_user(f"{name} is nearly black: if its 16 bits hold 12, multiply its values by 16")
    return pixels


@cache
def tell_of_turn() -> None:
    """Warn of a rotated picture, once."""
    warn_user(
        "pictures that viewers rotate, by EXIF or a video's metadata, are read as on the sensor"
    )


def pixels_of(image: Image.Image, mode: str | None = None) -> Pixels:
    """Return the pixels in a mode, RGB or RGBA; None = its own. Whole copies take more memory."""
    has_alpha = _eight_bits(image.crop((0, 0, 1, 1))).has_transparency_data
    mode = mode or ("RGBA" if has_alpha else "RGB")
    pixels = np.empty((image.height, image.width, len(mode)), np.uint8)
    for top, left in product(range(0, image.height, _TILE), range(0, image.width, _TILE)):
        part = pixels[top : top + _TILE, left : left + _TILE]
        tile = image.crop((left, top, left + part.shape[1], top + part.shape[0]))
        part[:] = np.asarray(_eight_bits(tile).convert(mode))
    return pixels


def _formats() -> list[str]:
    Image.init()
    return [kind for kind in Image.ID if kind not in _FOREIGN]


def image_suffixes() -> set[str]:
    """Return the suffixes of the files that `load_image` reads, and of those to be exported."""
    formats = _formats()
    return {
        *HEIC,
        *(end for end, kind in Image.registered_extensions().items() if kind in formats),
    }


def _eight_bits(image: Image.Image) -> Image.Image:
    """Return an image with 8 bits per channel; Pillow itself would clip 16-bit values at 255."""
    if image.mode == "F":
        raise ValueError("its pixels are floats; save it with 8 or 16 bits per channel")
    if not image.mode.startswith("I"):
        return image
    pixels = np.clip(np.asarray(image, dtype=np.int64), 0, _WHITE)
    return Image.fromarray((pixels * 255 // _WHITE).astype(np.uint8))


def save_image(path: str | PathLike[str], image: Pixels) -> None:
    """Write an image file in the format that its suffix names.

    Parameters
    ----------
    path : path
        The file to write, such as ``frame.png``.
    image : array (H, W, 3) of uint8
        RGB.

    Raises
    ------
    OSError
        If the file cannot be written.
    TypeError, ValueError
        If `image` has the wrong type or shape, or the suffix names no known format.

    Examples
    --------
    >>> robsim.vision.save_image("grey.png", np.full((4, 6, 3), 128, np.uint8))
    >>> robsim.vision.load_image("grey.png").shape
    (4, 6, 3)
    """
    file, file_format = image_file(path)
    pixels = check_pixels("image", image, 3)
    # Level 6, the default, takes four times as long for a fifth less; noise does not compress.
    options = {"compress_level": 1} if file_format == "PNG" else {}
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format=file_format, **options)
    write_whole(file, buffer.getvalue())


def image_file(path: str | PathLike[str]) -> tuple[Path, str]:
    """Return a file to write, and its format by its suffix; else raise TypeError or ValueError."""
    file = as_path(path)
    file_format = Image.registered_extensions().get(file.suffix.lower())
    if file_format not in Image.SAVE:
        raise ValueError(
            f"{one_line(file)}: the name of an image must end in .png, .jpg or similar"
        )
    return file, file_format


def check_pixels(name: str, pixels: Any, channels: int, alternative: str = "") -> Pixels:
    """Return an image (H, W, channels) of uint8; else raise TypeError or ValueError."""
    expected = f"{name} must be {alternative}a uint8 array of shape (H, W, {channels})"
    if not isinstance(pixels, np.ndarray):
        raise TypeError(f"{expected}, got {quoted(pixels)}")
    if pixels.dtype != np.uint8 or pixels.shape[2:] != (channels,) or not pixels.size:
        raise ValueError(f"{expected}, got {pixels.dtype} of shape {pixels.shape}")
    return pixels


def png_bytes(pixels: Pixels) -> bytes:
    """Return an image (H, W, 3) encoded as PNG, also for the core's frames."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", compress_level=1)
    return buffer.getvalue()


def resized(pixels: Pixels, width: int, height: int) -> Pixels:
    """Return an image (H, W, 3 or 4) of another size (px): box-averaged, or bicubic when larger."""
    if (width, height) == (pixels.shape[1], pixels.shape[0]):
        return pixels
    smaller = width <= pixels.shape[1] and height <= pixels.shape[0]
    method = Image.Resampling.BOX if smaller else Image.Resampling.BICUBIC
    return np.array(Image.fromarray(pixels).resize((width, height), method))


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
            f"{name} has {size[0]} x {size[1]} px, but the previous frames have {first[0]} x "
            f"{first[1]} px"
        )


#: Brightness in the shadow over the rightmost third of the view.
SHADOW = 0.8
# Each of the 256 channel values: from light to shadow, and from shadow to light.
_DARKENED = bytes(round(value * SHADOW) for value in range(256))
_LIGHTENED = bytes(min(round(value / SHADOW), 255) for value in range(256))


def darkened(pixels: Pixels) -> Pixels:
    return _looked_up(_DARKENED, pixels)


def lightened(pixels: Pixels) -> Pixels:
    return _looked_up(_LIGHTENED, pixels)


def _looked_up(table: bytes, pixels: Pixels) -> Pixels:
    """Return ``table[pixels]``; `bytes.translate` is several times faster than indexing."""
    looked_up = bytearray(np.ascontiguousarray(pixels)).translate(table)
    return np.frombuffer(looked_up, np.uint8).reshape(pixels.shape)
