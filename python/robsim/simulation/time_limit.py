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

# Interrupts a system call of the main thread; there is no such signal on Windows. By default it
# does nothing, and hardly anybody uses it: Go wakes its threads with it for the same reasons.
_WAKE_UP: Any = getattr(signal, "SIGURG", None) if hasattr(signal, "pthread_kill") else None

# Bytes: no struct sigaction is larger; that of Linux has 152.
_LARGEST_ACTION = 1024


class _TimeIsUp(BaseException):
    """Interrupts a callback; not caught by an ``except Exception`` in it."""


class TimeLimit:
    """Interrupts a callback, by a watchdog thread, after a maximum number of seconds, above 0.

    Code that never returns to the Python interpreter, such as an endless call of a compiled
    library, cannot be interrupted. Outside the main thread, and on Windows, a blocking system call
    cannot be interrupted, such as a sleep.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = check_float("time_limit", seconds, "s", exclusive_minimum=0)
        self._lock = threading.Lock()
        self._deadline = math.inf
        self._is_up = False
        self._thread = 0  # the one that runs the callbacks
        self._is_awakened = False  # the thread is interrupted by a signal
        self._is_watching = False

    def limited(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return the callback with the limit; it raises TimeoutError when the limit is exceeded."""

        @functools.wraps(callback)
        def call(*arguments: Any) -> Any:
            try:
                try:
                    self._deadline = time.monotonic() + self.seconds
                    result = callback(*arguments)
                finally:
                    with self._lock:
                        is_late = self._is_up or time.monotonic() > self._deadline
                        self._deadline, self._is_up = math.inf, False
            except _TimeIsUp as up:
                raise TimeoutError(self._message()).with_traceback(up.__traceback__) from None
            if is_late:
                raise TimeoutError(self._message())
            return result

        return call

    def _message(self) -> str:
        return f"the callback took longer than time_limit = {self.seconds:g} s"

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Enforce the limit on this thread's callbacks inside; around many runs it is cheaper."""
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
            if callable(before):  # somebody else's signal
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
                if time.monotonic() > self._deadline:
                    self._is_up = True
                    # interrupts again if the callback catches it and continues
                    self._deadline = time.monotonic() + self.seconds
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
