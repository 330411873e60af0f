"""Optional import of OpenCV, with its console output silenced."""

from __future__ import annotations

import importlib
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_lock = threading.Lock()
_redirection = threading.Lock()
_n_quiet = 0  # contexts of `quiet` that are open, in all threads
_level_before = 0
_LOG_LEVEL_SILENT = 0


def load_opencv(purpose: str) -> Any:
    """Return the module cv2.

    Its FFmpeg prints nothing, unless the program has read or written a video with OpenCV before,
    or has set OPENCV_FFMPEG_LOGLEVEL.

    Parameters
    ----------
    purpose : str
        What needs it, as the start of the error message: ``"reading a video"``.

    Raises
    ------
    ImportError
        If it is not installed; the message says how to install it.
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
