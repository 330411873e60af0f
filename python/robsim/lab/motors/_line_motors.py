"""What all motors at the end of a line have in common."""

from __future__ import annotations

import atexit
from contextlib import suppress
from typing import Self
from weakref import WeakSet

from robsim._core import Line, MotorLink
from robsim.base.text import quoted

#: s; a robot stops by itself when it hears nothing for so long.
TTL = 0.3
#: s; the link stops the robot when it gets no input for so long.
HOLD = 1.0

_open: WeakSet[LineMotors] = WeakSet()


class LineMotors(MotorLink):
    """A native link that stops the robot at the end of a ``with`` block and of the program."""

    def __init__(self, line: Line, address: str, *, ttl: float, hold: float) -> None:
        super().__init__(line, ttl=ttl, hold=hold)
        self._address = address
        _open.add(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        try:
            self.close()
        except OSError as trouble:
            if error is None:
                raise
            error.add_note(f"when the line to the robot was closed: {trouble}")

    def __repr__(self) -> str:
        state = ", closed" if self.is_closed else ", halted" if self.is_halted else ""
        return f"<{type(self).__name__} {quoted(self._address)}, ttl={self.ttl:g}{state}>"


@atexit.register
def _stop_all() -> None:
    links = list(_open)
    for link in links:  # all are told before one is waited for
        link.halt()
    for link in links:
        with suppress(OSError, RuntimeError):  # the line is cut; of the parent of a forked process
            link.close()
