"""Reads single pictures of a session's video."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image

from robsim.base.text import cut, one_line
from robsim.trace.sessions._matroska import find_pictures, read_at
from robsim.vision.imaging.images import MOST_PIXELS, Pixels


class Pictures:
    """The pictures of a video that `SessionWriter` wrote, or is writing.

    Parameters
    ----------
    file : Path
        The video.

    Attributes
    ----------
    torn : int
        Bytes at the end that are no whole picture.
    size : tuple of int
        Width and height of the pictures (px).

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is no video of a session.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        with self.opened() as descriptor:
            self._places, self.torn = find_pictures(file, descriptor)
            self.size = (0, 0)
            if self._places:
                pixels = self.read(descriptor, 0)
                self.size = (pixels.shape[1], pixels.shape[0])

    def __len__(self) -> int:
        return len(self._places)

    @contextmanager
    def opened(self) -> Iterator[int]:
        """Give a descriptor for `read` and `encoded`."""
        descriptor = os.open(self._file, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        try:
            yield descriptor
        finally:
            os.close(descriptor)

    def encoded(self, descriptor: int, number: int) -> bytes:
        """Return a picture as it stands in the file."""
        place = self._places[number]
        return read_at(descriptor, place.size, place.start)

    def read(self, descriptor: int, number: int) -> Pixels:
        """Return the pixels (H, W, 3) of a picture, RGB.

        Raises
        ------
        ValueError
            If it is damaged, too large, or of another size than the first one.
        """
        content = io.BytesIO(self.encoded(descriptor, number))
        try:
            with Image.open(content, formats=("JPEG", "PNG")) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    raise ValueError(f"{width} x {height} px are too many")
                if self.size not in ((0, 0), image.size):
                    raise ValueError(f"{width} x {height} px, unlike the first one")
                return np.array(image.convert("RGB"))
        except Exception as error:  # Pillow's decoders raise many types
            raise ValueError(
                f"frame {number} of {one_line(self._file)} is damaged: {cut(error)}"
            ) from error
