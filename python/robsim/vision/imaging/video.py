"""Writing frames to video files with PyAV, and tools for all video readers."""

from __future__ import annotations

import importlib
import math
import os
import re
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from os import SEEK_END, PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Frame
from robsim.base.checks import check_float
from robsim.base.files import PartialFile, as_path, naming, open_file
from robsim.base.text import one_line
from robsim.vision.imaging.images import (
    Pixels,
    check_iterable,
    check_same_size,
    frame_pixels,
    frame_size,
)

# A note at the end of a video file, in an element that players pass over: by suffix, the bytes
# before a text of 24 bytes.
_NOTE_LENGTH = 24
_PADDING = {
    ".mkv": b"\xec\x98",  # Void of Matroska
    ".webm": b"\xec\x98",
    ".avi": b"JUNK\x18\0\0\0",
    ".mp4": b"\0\0\0\x20free",
}
_NOTE = re.compile(rb"robsim headings ([1-9][0-9]{0,7}) *")


def note_headings(file: Path, headings: int) -> None:
    """Note at the end of a video the number of drawn headings of the robot."""
    text = f"robsim headings {headings}".encode().ljust(_NOTE_LENGTH)
    if len(text) > _NOTE_LENGTH:  # as good as any heading
        return
    with file.open("ab") as stream:
        stream.write(_PADDING[file.suffix.lower()] + text)


def noted_headings(file: Path) -> int | None:
    """Return the note of `note_headings` in a video; None = no note."""
    padding = _PADDING.get(file.suffix.lower())
    if padding is None:
        return None
    length = len(padding) + _NOTE_LENGTH
    with open_file(file) as stream:
        size = stream.seek(0, SEEK_END)
        stream.seek(max(0, size - length))
        end = stream.read(length)
    found = _NOTE.fullmatch(end.removeprefix(padding)) if end.startswith(padding) else None
    return int(found[1]) if found else None


_lock = threading.Lock()
_n_quiet = 0  # contexts of `quiet` that are open, in all threads
_level_before = 0
_LOG_LEVEL_SILENT = 0


def load_av(purpose: str) -> Any:
    """Return the module av; its ImportError begins with the purpose, ``"reading a video"``."""
    try:
        importlib.import_module("av.filter")
        return importlib.import_module("av")
    except ImportError as error:
        raise ImportError(f"{purpose} needs PyAV: pip install av") from error


def load_opencv(purpose: str) -> Any:
    """Return the module cv2; its ImportError begins with the purpose, ``"calibrating a lens"``.

    Its FFmpeg prints nothing, unless OpenCV read a stream before, or OPENCV_FFMPEG_LOGLEVEL is set.
    """
    # Looked at once, with the first stream.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # AV_LOG_QUIET
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        raise ImportError(f"{purpose} needs OpenCV: pip install opencv-python-headless") from error


@contextmanager
def quiet(cv2: Any) -> Iterator[None]:
    """Silence OpenCV's log inside the context; other output is not affected."""
    global _n_quiet, _level_before
    logging = getattr(cv2.utils, "logging", cv2)  # 4.8 has it in cv2 itself
    with _lock:
        if _n_quiet == 0:
            _level_before = logging.setLogLevel(_LOG_LEVEL_SILENT)
        _n_quiet += 1
    try:
        yield
    finally:
        with _lock:
            _n_quiet -= 1
            if _n_quiet == 0:
                logging.setLogLevel(_level_before)


LOSSLESS = "ffv1"
_INDEPENDENT = {"g": "1", "level": "3", "slicecrc": "1"}  # frames, with checksums
# Codec, format of its pixels and options, for each file suffix.
_CODECS: dict[str, tuple[str, str, dict[str, str]]] = {
    ".mp4": ("mpeg4", "yuv420p", {"qmin": "2", "qmax": "2", "b": "200M"}),
    ".webm": ("libvpx", "yuv420p", {"crf": "4", "b": "200M", "cpu-used": "4"}),
    ".mkv": (LOSSLESS, "bgr0", _INDEPENDENT),
    ".avi": (LOSSLESS, "bgr0", _INDEPENDENT),
}
_SMALL_WEBM = "libvpx", "yuv420p", {"crf": "30", "b": "4M", "cpu-used": "8", "deadline": "realtime"}
#: Suffixes of the files that can be written, for a user.
SUFFIXES = f"{', '.join(_CODECS)}; .mkv and .avi are lossless."


class VideoWriter:
    """A video file, written frame by frame, for a ``with`` statement.

    The suffix of the file name selects the codec. ``.mkv`` and ``.avi`` are lossless: use them for
    measurements (about 0.6 MB for a frame of 1200 x 1200 px). ``.mp4`` and ``.webm`` are much
    smaller, for viewing; browsers play ``.webm``. Both formats blur the markers' edges by a
    fraction of a pixel, which shifts a pose by about 0.2 px and 0.3 degrees.

    Frames of a simulation contain the number of headings in which the robot can be drawn. The file
    stores this number for `robsim.Recording`, in a note at its end. Arrays have no such number.

    The file gets its name when it is complete: at the end of the ``with`` block, also after an
    exception. Frames written before an exception are playable.

    Parameters
    ----------
    path : path
        The file to write.
    fps : float
        Frames per second, within 0.1..500.

    Raises
    ------
    FileNotFoundError
        If the folder of the file does not exist.
    ImportError
        If PyAV is not installed.
    OSError
        If the file cannot be written.
    TypeError, ValueError
        If the suffix is unknown or `fps` is out of range; at the end, if no frame was written.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1)
    >>> with robsim.vision.VideoWriter("run.mkv", fps=5) as video:
    ...     for _ in range(10):
    ...         video.write(sim.step().frame)
    >>> sum(1 for frame in robsim.Recording("run.mkv"))
    10
    """

    def __init__(self, path: str | PathLike[str], *, fps: float) -> None:
        self.path = as_path(path)
        self.count = 0
        if self.path.suffix.lower() not in _CODECS:
            known = ", ".join(_CODECS)
            raise ValueError(f"{one_line(path)}: the name of a video must end in {known}")
        self._codec = _CODECS[self.path.suffix.lower()]
        # MPEG-4 counts time in at most 65535 parts of a second.
        rate = check_float("fps", fps, "1/s", minimum=0.1, maximum=500)
        self._fps = round(rate, min(3, int(math.log10(65535 / rate))))
        folder = self.path.parent
        if not folder.is_dir():
            raise FileNotFoundError(f"{one_line(path)}: there is no folder {one_line(folder)}")
        self._av = load_av("writing a video")
        self._part: PartialFile | None = PartialFile(self.path, suffix=self.path.suffix.lower())
        self._size: tuple[int, int] | None = None
        self._headings: set[int | None] = set()  # of the frames

    def write(self, frame: Frame | Pixels) -> None:
        """Add a frame.

        Parameters
        ----------
        frame : Frame or array (H, W, 3) of uint8
            RGB. If H or W is odd, mp4 and webm repeat the last row or column.

        Raises
        ------
        OSError
            If the disk is full, or the codec does not support frames of this size.
        TypeError, ValueError
            If the frame has the wrong type or shape, or another size than the previous frames.
        """
        self._write("frame", frame)

    def _write(self, name: str, frame: Frame | Pixels) -> None:
        """Add a frame; the errors call it by the name."""
        if self._part is None:
            raise ValueError(f"{one_line(self.path)} is complete: open another VideoWriter")
        pixels = frame_pixels(name, frame)
        size = frame_size(pixels)
        check_same_size(f"frame {self.count}", size, self._size or size)
        codec, coding, options = self._codec
        if codec != LOSSLESS:  # the others need an even width and height
            odd = [(0, n % 2) for n in pixels.shape[:2]]
            pixels = np.pad(pixels, (*odd, (0, 0)), mode="edge")
        shown = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
        shown.pts = self.count
        with self._naming():
            if self._size is None:
                self._file = self._part.path.open("wb")
                self._size = size
                kind = "matroska" if self.path.suffix.lower() == ".mkv" else self.path.suffix[1:]
                self._container = self._av.open(self._file, "w", format=kind.lower())
                rate = Fraction(str(self._fps))
                self._stream = self._container.add_stream(codec, rate=rate, options=options)
                self._stream.width, self._stream.height = frame_size(pixels)
                self._stream.pix_fmt = coding
            self._container.mux(self._stream.encode(shown))
        self._headings.add(frame.headings if isinstance(frame, Frame) else None)
        self.count += 1

    def close(self) -> None:
        """Finish the file and give it its final name."""
        part, self._part = self._part, None
        if part is None:
            return
        try:
            if self.count:  # PyAV 19 crashes at the end of an encoder that knows no such frames
                with self._naming():
                    self._container.mux(self._stream.encode(None))
                    self._container.close()
                    self._file.close()
                (headings,) = self._headings if len(self._headings) == 1 else (None,)
                if headings is not None:
                    note_headings(part.path, headings)
                part.commit()
        finally:
            if self._size is not None:
                with suppress(OSError):  # a full disk
                    self._file.close()
            part.discard()

    @contextmanager
    def _naming(self) -> Iterator[None]:
        """Let an error of the disk or the codec name the file."""
        try:
            with naming(self.path):
                yield
        except self._av.FFmpegError as error:
            width, height = self._size or (0, 0)
            raise OSError(
                f"{one_line(self.path)} cannot be written with frames of {width} x {height} px"
            ) from error

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.close()
        if self.count == 0 and error is None:
            raise ValueError(f"{one_line(self.path)}: no frames were written")


def save_video(path: str | PathLike[str], frames: Iterable[Frame | Pixels], *, fps: float) -> None:
    """Write frames to a video file.

    If the iterable raises, the file contains the previous frames, and the exception propagates.

    Parameters
    ----------
    path : path
        The file to write; for the suffixes see `VideoWriter`.
    frames : iterable of Frame or array (H, W, 3) of uint8
        The frames, all of one size.
    fps : float
        Frames per second, within 0.1..500.

    Raises
    ------
    ImportError, OSError, TypeError, ValueError
        As for `VideoWriter`.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1)
    >>> robsim.vision.save_video("run.mkv", (sim.step().frame for _ in range(5)), fps=5)
    >>> sum(1 for frame in robsim.Recording("run.mkv"))
    5
    """
    check_iterable(frames)
    with VideoWriter(path, fps=fps) as video:
        for index, frame in enumerate(frames):
            video._write(f"frames[{index}]", frame)


def save_small_video(file: Path, frames: Iterable[Pixels], *, fps: float) -> None:
    """Write a .webm for viewing, about a seventh of the size."""
    with VideoWriter(file, fps=fps) as video:
        video._codec = _SMALL_WEBM
        for frame in frames:
            video.write(frame)
