"""A user's object as a camera."""

from __future__ import annotations

import math
import time
from typing import Any

from robsim.base.text import quoted
from robsim.lab.cameras.errors import CaptureError

_AHEAD = 0.02  # s, by which the clocks of some systems are coarse
_OLDEST = 60.0  # s


class CalledCamera:
    """The camera of an object with `open`, `read` and `close`, whose times are checked."""

    def __init__(self, camera: Any) -> None:
        self._camera = camera
        self.open, self.close = camera.open, camera.close
        self.knows_exposure = False  # of the last frame

    def read(self) -> Any:
        """Return the result of the object; raise CaptureError for a time of another clock."""
        read = self._camera.read()
        if isinstance(read, tuple) and len(read) in (2, 5):
            self.knows_exposure = read[1] is not None
            for name, seconds in zip(("exposed", "arrived"), read[1:3], strict=False):
                if seconds is not None:
                    _check_time(name, seconds)
        return read


def _check_time(name: str, seconds: Any) -> None:
    now = time.monotonic()
    try:
        age = now - float(seconds)
    except (TypeError, ValueError):
        age = math.nan
    if not -_AHEAD <= age <= _OLDEST:
        raise CaptureError(
            f"{name} of read() must be time.monotonic() in s, at most {_OLDEST:g} s old, got "
            f"{quoted(seconds)} at {now:.3f} s"
        )
