"""Writing frames to video files with OpenCV."""

from __future__ import annotations

import importlib
import math
import os
import re
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from os import SEEK_END, PathLike
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import Frame
from robsim.base.checks import check_float
from robsim.base.files import PartialFile, as_path, content_of, open_file
from robsim.base.text import one_line
from robsim.vision.imaging.images import (
    Pixels,
    check_iterable,
    check_same_size,
    frame_pixels,
    frame_size,
)

_SYNC = rb"\x47.{%d}\x47"  # of packets in a transport stream
# Each container that FFmpeg reads and that holds its own frames, by its first bytes.
_CONTAINERS = re.compile(
    rb"|".join(
        (
            rb".{4}(?:ftyp|moov|mdat|wide|free|skip|pnot)",  # MP4, QuickTime
            rb"\x1a\x45\xdf\xa3",  # Matroska, WebM
            rb"RIFF.{4}AVI ",
            rb"OggS",
            rb"FLV\x01",
            rb"\x30\x26\xb2\x75\x8e\x66\xcf\x11",  # WMV
            rb"\x00\x00\x01[\xb3\xba]",  # MPEG-1, MPEG-2
            rb"\x06\x0e\x2b\x34",  # MXF
            rb"DKIF",  # IVF
            rb"YUV4MPEG2 ",
            _SYNC % 187,  # MPEG-TS
            rb".{4}" + _SYNC % 191,  # from a camcorder
            rb"GIF8[79]a",
        )
    ),
    re.DOTALL,
)
_LONGEST = 200  # bytes
# FFmpeg never takes a file with such a suffix for an image.
_SUFFIXES = frozenset(
    (
        *(".avi", ".flv", ".m2ts", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg"),
        *(".mpg", ".mts", ".mxf", ".ogv", ".ts", ".webm", ".wmv"),
    )
)


def check_is_video(file: Path) -> None:
    """Raise a ValueError unless a file begins as a video does.

    FFmpeg also reads playlists, and patterns of names of images: the frames of other files.
    """
    kind = Image.registered_extensions().get(file.suffix.lower())
    if kind not in (None, "MPEG", "GIF"):
        raise ValueError(f"{one_line(file)} is an image, not a video: give its folder")
    if file.suffix.lower() not in _SUFFIXES and re.search(r"[%*?{\[]", file.name):
        raise ValueError(
            f"{one_line(file)} has a name that stands for several images: give their folder, or "
            "rename it"
        )
    if not _CONTAINERS.match(content_of(file, _LONGEST)):
        raise ValueError(
            f"{one_line(file)} is not a video, or it is damaged: it begins as none does that has "
            "its frames in it"
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
    """Note at the end of a video how many headings the robot is drawn in."""
    text = f"robsim headings {headings}".encode().ljust(_NOTE_LENGTH)
    if len(text) > _NOTE_LENGTH:  # as good as any heading
        return
    with file.open("ab") as stream:
        stream.write(_PADDING[file.suffix.lower()] + text)


def noted_headings(file: Path) -> int | None:
    """Return what `note_headings` has noted in a video; None = nothing."""
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
_redirection = threading.Lock()
_n_quiet = 0  # contexts of `quiet` that are open, in all threads
_level_before = 0
_LOG_LEVEL_SILENT = 0


def load_opencv(purpose: str) -> Any:
    """Return the module cv2; its ImportError begins with the purpose, ``"reading a video"``.

    Its FFmpeg prints nothing, unless OpenCV read or wrote a video before, or OPENCV_FFMPEG_LOGLEVEL
    is set.
    """
    # Looked at once, with the first video.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # AV_LOG_QUIET
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        raise ImportError(f"{purpose} needs OpenCV: pip install opencv-python-headless") from error


@contextmanager
def quiet(cv2: Any) -> Iterator[None]:
    """Let OpenCV log nothing inside the context; what else prints is not touched."""
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


@contextmanager
def discarded_stderr() -> Iterator[None]:
    """Discard what the whole process writes to stderr: for a moment, where nothing else helps."""
    with _redirection:  # two threads at once would restore each other's
        try:
            saved = os.dup(2)
        except OSError:  # a program without a terminal may have none
            yield
            return
        try:
            with open(os.devnull, "wb") as sink:
                os.dup2(sink.fileno(), 2)
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)


#: FourCC code of the codec for each file suffix.
CODECS = {".mp4": "mp4v", ".webm": "VP80", ".mkv": "FFV1", ".avi": "FFV1"}
LOSSLESS = "FFV1"
_LOSSLESS_SUFFIXES = " and ".join(suffix for suffix, codec in CODECS.items() if codec == LOSSLESS)
#: Suffixes of the files that can be written, for a user.
SUFFIXES = f"{', '.join(CODECS)}; {_LOSSLESS_SUFFIXES} are lossless."


class VideoWriter:
    """A video file that is written frame by frame, for a ``with`` statement.

    The suffix of the file name selects the codec. ``.mkv`` and ``.avi`` are lossless: use them for
    measurements (about 0.6 MB for a frame of 1200 x 1200 px). ``.mp4`` and ``.webm`` are much
    smaller, for viewing; browsers play ``.webm``. They blur the edges of the markers by a fraction
    of a pixel, which shifts a pose by about 0.2 px and 0.3 degrees.

    Frames of a simulation tell in how many headings the robot is drawn; the file keeps that for
    `robsim.Recording`, in a note at its end. Arrays do not tell it.

    The file gets its name when it is complete: when the ``with`` block ends, also by an exception.
    The frames written before an exception can be played.

    Parameters
    ----------
    path : path
        The file to write.
    fps : float
        Frames per second, within 0.1..500.

    Raises
    ------
    FileNotFoundError
        If its folder does not exist.
    ImportError
        If OpenCV is not installed.
    OSError
        If the file cannot be written.
    TypeError, ValueError
        If the suffix is unknown or `fps` is out of range; at the end, if there were no frames.

    Examples
    --------
    >>> with robsim.vision.VideoWriter("run.webm", fps=5) as video:
    ...     for _ in range(100):
    ...         video.write(sim.step().frame)
    """

    def __init__(self, path: str | PathLike[str], *, fps: float) -> None:
        self.path = as_path(path)
        self.count = 0
        self._codec = _codec(self.path)
        # MPEG-4 counts time in at most 65535 parts of a second.
        rate = check_float("fps", fps, "1/s", minimum=0.1, maximum=500)
        self._fps = round(rate, min(3, int(math.log10(65535 / rate))))
        if not self.path.absolute().parent.is_dir():
            raise FileNotFoundError(
                f"{one_line(self.path)}: there is no folder {one_line(self.path.parent)}"
            )
        if self.path.is_dir():
            raise IsADirectoryError(
                f"{one_line(self.path)} is a folder, not a file: give another name"
            )
        if not os.access(self.path.absolute().parent, os.W_OK):
            raise PermissionError(
                f"{one_line(self.path)}: the folder {one_line(self.path.parent)} cannot be "
                "written to"
            )
        self._cv2 = load_opencv("writing a video")
        self._part: PartialFile | None = None
        self._size = (0, 0)
        self._writer: Any = None
        self._headings: set[int | None] = set()  # of the frames
        self._is_closed = False

    def write(self, frame: Frame | Pixels) -> None:
        """Add a frame.

        Parameters
        ----------
        frame : Frame or array (H, W, 3) of uint8
            RGB. If H or W is odd, mp4 and webm repeat the last row or column.

        Raises
        ------
        TypeError, ValueError
            If it has the wrong type or shape, has another size than the frames before, or has an
            odd width or height and the codec is lossless.
        """
        self._write("frame", frame)

    def _write(self, name: str, frame: Frame | Pixels) -> None:
        """Add a frame; the errors call it by the name."""
        if self._is_closed:
            raise ValueError(f"{one_line(self.path)} is complete: open another VideoWriter")
        pixels = frame_pixels(name, frame)
        even = _even(pixels, self._codec)
        if self._writer is None:
            self._size = frame_size(pixels)
            self._writer = self._open(frame_size(even))
        check_same_size(f"frame {self.count}", frame_size(pixels), self._size)
        bgr = self._cv2.cvtColor(even, self._cv2.COLOR_RGB2BGR)
        with quiet(self._cv2):
            self._writer.write(bgr)
        self._headings.add(frame.headings if isinstance(frame, Frame) else None)
        self.count += 1

    def close(self) -> None:
        """Finish the file and give it its name."""
        self._is_closed = True
        if self._writer is None:
            return
        writer, part = self._writer, self._part
        assert part is not None
        self._writer = self._part = None
        try:
            with quiet(self._cv2):
                writer.release()
                video = self._cv2.VideoCapture(str(part.path), self._cv2.CAP_FFMPEG)
                # OpenCV does not report a full disk, and the header may claim too many frames.
                written = sum(1 for _ in iter(video.grab, False))
                video.release()
            if written < self.count:  # one more if Ctrl-C came before it was counted
                raise OSError(
                    f"{one_line(self.path)} could not be written: the disk is full, or the "
                    "frames are too small"
                )
            (headings,) = self._headings if len(self._headings) == 1 else (None,)
            if headings is not None:
                note_headings(part.path, headings)
            part.commit()
        finally:
            part.discard()

    def _open(self, size: tuple[int, int]) -> Any:
        codec = self._cv2.VideoWriter_fourcc(*self._codec)
        part = PartialFile(self.path, suffix=self.path.suffix.lower())
        # OpenCV prints a line for each WebM, past its log.
        is_loud = self.path.suffix.lower() == ".webm"
        with quiet(self._cv2), discarded_stderr() if is_loud else nullcontext():
            writer = self._cv2.VideoWriter(
                str(part.path), self._cv2.CAP_FFMPEG, codec, self._fps, size
            )
        if not writer.isOpened():
            part.discard()
            raise OSError(
                f"{one_line(self.path)} cannot be written with frames of {size[0]} x {size[1]} px"
            )
        self._part = part
        return writer

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.close()
        if self.count == 0 and error is None:
            raise ValueError(f"{one_line(self.path)}: there were no frames to write")


def save_video(path: str | PathLike[str], frames: Iterable[Frame | Pixels], *, fps: float) -> None:
    """Write frames to a video file.

    If the iterable raises, the file contains the frames before, and the exception propagates.

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
        As `VideoWriter`.
    """
    check_iterable(frames)
    with VideoWriter(path, fps=fps) as video:
        for index, frame in enumerate(frames):
            video._write(f"frames[{index}]", frame)


def _codec(path: Path) -> str:
    try:
        return CODECS[path.suffix.lower()]
    except KeyError:
        known = ", ".join(CODECS)
        raise ValueError(f"{one_line(path)}: the name of a video must end in {known}") from None


def _even(pixels: Pixels, codec: str) -> Pixels:
    """Return the pixels with an even width and height, which the codecs need."""
    height, width = pixels.shape[:2]
    if height % 2 == 0 and width % 2 == 0:
        return pixels
    if codec == LOSSLESS:
        raise ValueError(
            f"frames of {width} x {height} px do not fit into a lossless video: width and height "
            "must be even; use .mp4 or .webm, or crop a row or column"
        )
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
