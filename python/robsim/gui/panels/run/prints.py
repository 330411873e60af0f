"""The newest lines printed by callbacks; the terminal shows them, too."""

from __future__ import annotations

import functools
import sys
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from robsim.simulation.callbacks.signatures import CallTimes

_MOST_LINES = 100
_LONGEST = 200  # characters of a line
_replacing = threading.Lock()
_here = threading.local()  # `heard` takes the text of the running callback


class _Tee:
    """A stream that passes text on, and copies a callback's text to its panel."""

    def __init__(self, stream: Any) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        if (heard := getattr(_here, "heard", None)) is not None and isinstance(text, str):
            heard(text)
        return self.stream.write(text)  # type: ignore[no-any-return]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


class HeardCalls(CallTimes):
    """Times the calls of callbacks, and keeps their last printed lines."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: deque[tuple[str, str]] = deque(maxlen=_MOST_LINES)  # slot, text
        self.n_heard = 0  # lines in total
        self._open: dict[str, str] = {}  # by slot: the beginning of an unfinished line
        self._has_ended = False

    def timed(self, slot: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a callback with timed calls and recorded prints."""
        hear = functools.partial(self._hear, slot)

        @functools.wraps(callback, updated=())
        def call(*arguments: Any) -> Any:
            with _replacing:  # other code may replace it, too; None in pythonw
                if not (self._has_ended or sys.stdout is None or type(sys.stdout) is _Tee):
                    sys.stdout = _Tee(sys.stdout)
            before, _here.heard = getattr(_here, "heard", None), hear
            try:
                return callback(*arguments)
            finally:
                _here.heard = before

        return super().timed(slot, call)

    def clear(self) -> None:
        """Forget all lines."""
        self.lines.clear()
        self.n_heard += 1

    def end(self) -> None:
        """Restore the program's own stream."""
        with _replacing:
            self._has_ended = True
            if isinstance(tee := sys.stdout, _Tee):
                sys.stdout = tee.stream

    def _hear(self, slot: str, text: str) -> None:
        most = _MOST_LINES * _LONGEST
        *lines, rest = (self._open.get(slot, "") + text[-most:]).split("\n")
        self.lines.extend((slot, line[:_LONGEST]) for line in lines[-_MOST_LINES:])
        self.n_heard += len(lines)
        self._open[slot] = rest[:_LONGEST]
