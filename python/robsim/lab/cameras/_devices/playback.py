"""A video file or a folder of images, played at its own rate."""

from __future__ import annotations

import time
from collections.abc import Iterator
from os import PathLike
from typing import Any

from robsim._core import Frame
from robsim.base.text import one_line
from robsim.lab.cameras.errors import CaptureError, EndOfStream
from robsim.vision.imaging.recordings import Recording

_LONGEST_WAIT = 0.1  # s in one call


class Playback:
    """The camera of a file, played at its own or another rate (1/s); a folder requires a rate."""

    def __init__(self, source: str | PathLike[str], fps: float | None) -> None:
        self._recording = Recording(source, dt=None if fps is None else 1 / fps)
        self.name = one_line(source)
        if self._recording._times is None:
            raise ValueError(
                f"fps must be given to play the folder {self.name}: its images have no times"
            )
        self.dt = self._recording.dt
        self.headings = self._recording.headings
        self._frames: Iterator[Frame] = iter(())
        self._next: Frame | None = None
        self._start: float | None = None

    def open(self) -> None:
        """Begin with the first frame."""
        self._frames = iter(self._recording)
        self._next = self._start = None

    def read(self) -> tuple[Any, float] | None:
        """Return the next frame and its time, or None before its time."""
        if self._next is None:
            try:
                self._next = next(self._frames)
            except StopIteration:
                raise EndOfStream(f"{self.name} is over") from None
            except ValueError as error:
                raise CaptureError(str(error)) from error
        if self._start is None:
            self._start = time.monotonic()
        due = self._start + (self._next.t or 0.0)
        wait = due - time.monotonic()
        time.sleep(min(max(wait, 0.0), _LONGEST_WAIT))
        if wait > _LONGEST_WAIT:
            return None
        frame, self._next = self._next, None
        return frame.image, due

    def close(self) -> None:
        """Close the file."""
        self._frames = iter(())
        self._next = None
