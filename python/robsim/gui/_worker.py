"""A thread of its own, which does one job after another."""

from __future__ import annotations

import atexit
import math
import os
import threading
import time
import traceback
import weakref
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

_IDLE = 10.0  # s without anything to do, after which the thread ends until there is
_LAST_PATIENCE = 1.0  # s for all threads together when Python ends
_LONGEST_WAIT = 3600.0  # s; conditions take no infinity
_MOST_REPORTS = 100
_at_work: weakref.WeakSet[Worker] = weakref.WeakSet()
_lock = threading.Lock()  # of that
#: Held to draw a figure: one at a time.
drawing = threading.Lock()


class Worker(ABC):
    """Does jobs, one after another, and what is due by itself, in a thread of its own.

    The thread begins with the first job, and ends where nothing is to be done for a while: who is
    forgotten without having been closed is collected like any other object, unless it is at work.
    In a forked process, which has not got the thread, it takes no jobs.
    """

    _thread_name: ClassVar[str]

    def __init__(self) -> None:
        self._jobs: deque[Callable[[], object]] = deque()
        self._wake = threading.Condition()
        self._is_over = self._is_working = False
        self._thread: threading.Thread | None = None
        self._process = os.getpid()
        self._reported: set[tuple[str, int]] = set()

    def post(self, job: Callable[[], object], *, first: bool = False) -> bool:
        """Do a job in the thread, before all others if `first`; False if the thread has ended."""
        if self._is_elsewhere:
            return False
        with self._wake:
            if self._is_over:
                return False
            if self._thread is None:
                self._begin()
            if first:
                self._jobs.appendleft(job)
            else:
                self._jobs.append(job)
            self._wake.notify()
        return True

    def close(self, timeout: float = 5.0) -> bool:
        """End the thread after its job; return whether it ended within the timeout (s).

        A thread that hangs is left behind, and ends with Python. In the thread itself, it is False.
        """
        if self._is_elsewhere:
            return True
        with self._wake:
            thread, was_over = self._thread, self._is_over
            self._end()
        if thread is None:
            if not was_over:
                self._finish()
            return True
        if thread is not threading.current_thread():
            thread.join(timeout)
        return not thread.is_alive()

    def guarded(self, job: Callable[..., Any], *arguments: object) -> Any:
        """Do something in which a mistake of ours must not end the thread; None if there is one."""
        try:
            return job(*arguments)
        except Exception as error:
            self.report(error)
            return None

    def report(self, error: BaseException) -> bool:
        """Report an exception as of an ended thread; False for a place that was reported before."""
        frames = traceback.extract_tb(error.__traceback__, -1)
        place = (frames[0].filename, frames[0].lineno or 0) if frames else ("", 0)
        if place in self._reported or len(self._reported) >= _MOST_REPORTS:
            return False
        self._reported.add(place)
        about = type(error), error, error.__traceback__, threading.current_thread()
        threading.excepthook(threading.ExceptHookArgs(about))
        return True

    @property
    def _is_elsewhere(self) -> bool:
        """Whether this is a process that was forked from the one with the thread."""
        return self._process != os.getpid()

    @property
    def is_over(self) -> bool:
        """Whether it takes no more jobs."""
        return self._is_over

    @property
    def is_here(self) -> bool:
        return threading.current_thread() is self._thread

    def _begin(self) -> None:
        thread = threading.Thread(target=self._work, name=self._thread_name, daemon=True)
        thread.start()  # it waits for the lock
        self._thread = thread
        with _lock:
            _at_work.add(self)

    def _end(self) -> None:
        """Take no more jobs, with the lock held; what waits is done before the thread ends."""
        self._is_over = True
        self._wake.notify()

    # In the thread.

    @abstractmethod
    def _due(self) -> float:
        """Return when there is something to do without a job, by the monotonic clock."""

    @abstractmethod
    def _do_due(self) -> None:
        """Do what is due."""

    def _finish(self) -> None:  # noqa: B027  # not all have something to do
        """Do what comes last."""

    def _rest(self) -> None:  # noqa: B027
        """Do what comes after each job."""

    def _work(self) -> None:
        while (job := self._next_job()) is not None:
            self.guarded(job)
            del job  # it may hold much, such as a frame
            self.guarded(self._rest)
        if self.is_here:  # otherwise it has only run out of jobs
            self.guarded(self._finish)

    def _next_job(self) -> Callable[[], object] | None:
        with self._wake:
            self._is_working = False
            while not (self._jobs or self._is_over):
                due = self._due()
                if (wait := due - time.monotonic()) <= 0:
                    self._is_working = True
                    return self._do_due
                is_news = self._wake.wait(_IDLE if due == math.inf else min(wait, _LONGEST_WAIT))
                if not (is_news or self._jobs or self._is_over or self._due() < math.inf):
                    self._thread = None
                    return None
            self._is_working = bool(self._jobs)
            return self._jobs.popleft() if self._jobs else None


def at_work() -> list[Worker]:
    """Return all whose thread has begun."""
    with _lock:
        return [*_at_work]


@atexit.register
def close_all() -> None:
    """Close all workers: threads in native code must not outlive Python."""
    workers = at_work()
    for worker in workers:  # all are told before one is waited for
        worker.close(0)
    end = time.monotonic() + _LAST_PATIENCE
    for worker in workers:
        worker.close(max(0.0, end - time.monotonic()))


if hasattr(os, "register_at_fork"):
    # Their threads are the parent's; another one of them may have had the lock.
    os.register_at_fork(before=_lock.acquire, after_in_parent=_lock.release)
    os.register_at_fork(after_in_child=_at_work.clear)
    os.register_at_fork(after_in_child=_lock.release)


T = TypeVar("T")


class Beside:
    """Computes one thing at a time, in a new thread each time."""

    def __init__(self, worker: Worker, name: str) -> None:
        self._worker, self._name = worker, name
        self._thread: threading.Thread | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a result has not been taken yet."""
        return self._thread is not None

    def begin(self, compute: Callable[[], T], take: Callable[[T | None], None]) -> None:
        """Compute something; `take` gets it, or None where a mistake of ours was reported."""

        def work() -> None:
            result = self._worker.guarded(compute)
            self._worker.post(lambda: done(result))

        def done(result: T | None) -> None:
            self._thread = None
            take(result)

        self._thread = threading.Thread(target=work, name=self._name, daemon=True)
        self._thread.start()

    def wait(self, timeout: float | None = None) -> None:
        """Wait until nothing is computed; any thread may call this (None: as long as it takes)."""
        if (thread := self._thread) is not None:
            thread.join(timeout)
