"""Optional import of OpenCV, with its console output silenced."""

from __future__ import annotations

import importlib
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_lock = threading.RLock()


def load_opencv(purpose: str) -> Any:
    """Return the module cv2.

    Parameters
    ----------
    purpose : str
        What needs it, as the start of the error message: ``"reading a video"``.

    Raises
    ------
    ImportError
        If it is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        raise ImportError(f"{purpose} needs OpenCV: pip install 'robsim[camera]'") from error


@contextmanager
def quiet() -> Iterator[None]:
    """Discard what OpenCV and FFmpeg print inside the context.

    They write to the stderr of the process. Their log levels do not cover everything, and would
    stay changed for other code that uses OpenCV.
    """
    with _lock:  # two threads at once would restore each other's redirection
        saved = _stderr_copy()
        if saved is None:
            yield
            return
        try:
            with open(os.devnull, "wb") as sink:
                os.dup2(sink.fileno(), 2)
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)


def _stderr_copy() -> int | None:
    try:
        return os.dup(2)
    except OSError:  # a program without a terminal may have none
        return None
