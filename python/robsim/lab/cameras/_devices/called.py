"""A user's object as a camera."""

from __future__ import annotations

import time
from typing import Any

from robsim.base.checks import check_float

_AHEAD = 0.02  # s, by which the clocks of some systems are coarse
_OLDEST = 60.0  # s


class CalledCamera:
    """The camera of an object with `open`, `read` and `close`, whose times are checked."""

    def __init__(self, camera: Any) -> None:
        self._camera = camera
        self.open, self.close = camera.open, camera.close
        self.knows_exposure = False  # of the last frame

    def read(self) -> Any:
        """Return the result of the object; raise ValueError for a time of another clock."""
        read = self._camera.read()
        if isinstance(read, tuple) and len(read) in (2, 5):
            self.knows_exposure = read[1] is not None
            now = time.monotonic()
            for name, seconds in zip(("exposed", "arrived"), read[1:3], strict=False):
                if seconds is not None:
                    called = f"{name} of read() must be time.monotonic() in s: it"
                    check_float(called, seconds, minimum=now - _OLDEST, maximum=now + _AHEAD)
        return read
