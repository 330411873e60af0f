"""A time limit for callbacks, for `Simulation(time_limit=...)` and the doctor."""

from __future__ import annotations

import ctypes
import functools
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from types import FrameType
from typing import Any

from robsim.base.checks import check_float
from robsim.base.in_browser import check_has_threads

# Interrupts a system call of the main thread; there is no such signal on Windows. By default it
# does nothing, and hardly anybody uses it: Go wakes its threads with it for the same reasons.
_WAKE_UP: Any = getattr(signal, "SIGURG", None) if hasattr(signal, "pthread_kill") else None

_AGAIN = 1.0  # s after which a callback that continues is interrupted again, at most

# Bytes: no struct sigaction is larger; that of Linux has 152.
_LARGEST_ACTION = 1024


class _TimeIsUp(BaseException):
    """Interrupts a callback; not caught by an ``except Exception`` in it."""


#: Modules whose frames stand on the stack of a thread while a debugger waits there.
_DEBUGGERS = {"bdb", "pdb", "pydevd", "_pydevd_bundle"}


class TimeLimit:
    """Interrupts a callback, by a watchdog thread, after a maximum number of seconds, above 0.

    While a debugger waits in the callback, no time passes.

    Code that never returns to the Python interpreter, such as an endless call of a compiled
    library, cannot be interrupted. Outside the main thread, and on Windows, a blocking system call
    cannot be interrupted, such as a sleep.
    """

    def __init__(self, seconds: float) -> None:
        check_has_threads("time_limit")
        self.seconds = check_float("time_limit", seconds, "s", exclusive_minimum=0)
        self._lock = threading.Lock()
        self._deadline = math.inf
        self._is_up = False
        self._why = ""  # it is interrupted, if not by the limit
        self._thread = 0  # the one that runs the callbacks
        #: Name and start of the call under way, start of its interruption (monotonic clock, s).
        self.call: tuple[str, float] | None = None
        self.interrupted: float | None = None
        self._is_awakened = False  # the thread is interrupted by a signal
        self._is_watching = False

    @property
    def frame(self) -> FrameType | None:
        """The current place of the callbacks' thread; any thread may read this."""
        return sys._current_frames().get(self._thread)

    @property
    def is_debugged(self) -> bool:
        """Whether a debugger waits in the callback."""
        frame = self.frame
        while frame is not None:
            if str(frame.f_globals.get("__name__")).partition(".")[0] in _DEBUGGERS:
                return True
            frame = frame.f_back
        return False

    def end(self, why: str, call: tuple[str, float] | None) -> None:
        """End a call if it still is the one under way."""
        with self._lock:
            is_it = call is not None and self.call is call
            if is_it and self._deadline < math.inf and self.interrupted is None:
                self._why, self._deadline = why, -math.inf

    def limited(self, callback: Callable[..., Any], name: str = "") -> Callable[..., Any]:
        """Return the callback with the limit, beyond which it raises TimeoutError."""

        @functools.wraps(callback)
        def call(*arguments: Any) -> Any:
            try:
                try:
                    now = time.monotonic()
                    self._why, self.call, self._deadline = "", (name, now), now + self.seconds
                    result = callback(*arguments)
                finally:
                    with self._lock:
                        is_late = self._is_up or time.monotonic() > self._deadline > -math.inf
                        self._deadline, self._is_up = math.inf, False
                        self.call = self.interrupted = None
            except _TimeIsUp as up:
                raise TimeoutError(self._message()).with_traceback(up.__traceback__) from None
            if is_late:
                raise TimeoutError(self._message())
            return result

        return call

    def _message(self) -> str:
        return self._why or f"the callback took longer than time_limit = {self.seconds:g} s"

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Enforce the limit on this thread's callbacks; one context for many runs is cheaper."""
        if self._is_watching and self._thread == threading.get_ident():
            yield
            return
        self._thread = threading.get_ident()
        self._deadline, self._is_up = math.inf, False
        is_main = threading.current_thread() is threading.main_thread()
        self._is_awakened = is_main and _WAKE_UP is not None
        done = threading.Event()
        watch = threading.Thread(target=self._watch, args=(done,), daemon=True)
        with self._awakened() if self._is_awakened else nullcontext():
            try:
                watch.start()
                self._is_watching = True
                yield
            finally:
                self._is_watching = False
                done.set()
                if watch.ident is not None:
                    watch.join()

    @contextmanager
    def _awakened(self) -> Iterator[None]:
        """Interrupt the callback when the signal comes that the watchdog sends."""
        before = signal.getsignal(_WAKE_UP)

        def interrupt(signum: int, frame: FrameType | None) -> None:
            if self._is_up:
                raise _TimeIsUp
            if callable(before):  # a previous handler
                before(signum, frame)

        with _signal_kept(_WAKE_UP):
            signal.signal(_WAKE_UP, interrupt)
            try:
                yield
            finally:
                signal.signal(_WAKE_UP, before or signal.SIG_DFL)

    def _watch(self, done: threading.Event) -> None:
        while not done.wait(min(self.seconds / 4, 0.05)):
            with self._lock:
                if (now := time.monotonic()) <= self._deadline:
                    continue
                self._deadline = now + self.seconds
                if not self.is_debugged:
                    # interrupts again if the callback catches it and continues
                    self._deadline = now + min(self.seconds, _AGAIN)
                    self._is_up = True
                    self.interrupted = self.interrupted or now
                    self._interrupt_callback()

    def _interrupt_callback(self) -> None:
        if sys.platform != "win32" and self._is_awakened:
            signal.pthread_kill(self._thread, _WAKE_UP)
        else:
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(self._thread), ctypes.py_object(_TimeIsUp)
            )


@contextmanager
def _signal_kept(signum: int) -> Iterator[None]:
    """Restore a signal handler set in C, as by `faulthandler.register`, unknown to Python."""
    action = ctypes.create_string_buffer(_LARGEST_ACTION)
    system = ctypes.CDLL(None)
    system.sigaction(int(signum), None, action)
    try:
        yield
    finally:
        system.sigaction(int(signum), action, None)
