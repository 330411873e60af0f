"""A thread that does one job after another."""

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

_IDLE = 10.0  # s without work, after which the thread ends until the next job
_LAST_PATIENCE = 1.0  # s for all threads together when Python ends
_LONGEST_WAIT = 3600.0  # s; conditions accept no infinity
_MOST_REPORTS = 100
_at_work: weakref.WeakSet[Worker] = weakref.WeakSet()
_lock = threading.Lock()  # of `_workers`
#: Held while drawing a figure: one at a time.
drawing = threading.Lock()


class Worker(ABC):
    """Does jobs, one after another, and due work, in a separate thread.

    The thread begins with the first job, and ends after a while without work. An idle worker that
    was not closed is garbage-collected like any other object. A forked process lacks the thread,
    so its copy takes no jobs.
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
            if self._thread is None and not self._begin():
                return False
            if first:
                self._jobs.appendleft(job)
            else:
                self._jobs.append(job)
            self._wake.notify()
        return True

    def close(self, timeout: float = 5.0) -> bool:
        """End the thread after its job; return whether the thread ended within the timeout (s).

        A hanging thread is left behind, and ends with Python. In the thread itself, return False.
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
        """Do something; report an internal error, and return None instead of ending the thread."""
        try:
            return job(*arguments)
        except Exception as error:
            self.report(error)
            return None

    def report(self, error: BaseException) -> bool:
        """Report an exception like a failed thread; False if its place was reported before."""
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
        """Whether this process was forked from the process with the thread."""
        return self._process != os.getpid()

    @property
    def is_over(self) -> bool:
        """Whether the worker takes no more jobs."""
        return self._is_over

    @property
    def is_here(self) -> bool:
        return threading.current_thread() is self._thread

    def _begin(self) -> bool:
        thread = threading.Thread(target=self._work, name=self._thread_name, daemon=True)
        try:
            thread.start()  # the thread waits for the lock
        except RuntimeError:
            if threading.main_thread().is_alive():
                raise
            return False  # Python 3.12 starts no thread at the program's end
        self._thread = thread
        with _lock:
            _at_work.add(self)
        return True

    def _end(self) -> None:
        """Refuse further jobs, with the lock held; waiting jobs run before the thread ends."""
        self._is_over = True
        self._wake.notify()

    # In the thread.

    @abstractmethod
    def _due(self) -> float:
        """Return the time of the next work without a job, by the monotonic clock."""

    @abstractmethod
    def _do_due(self) -> None:
        """Do the due work."""

    def _finish(self) -> None:  # noqa: B027  # not all have something to do
        """Do the last work before the end."""

    def _rest(self) -> None:  # noqa: B027
        """Do the work after each job."""

    def _work(self) -> None:
        while (job := self._next_job()) is not None:
            self.guarded(job)
            del job  # the job may hold much memory, such as a frame
            self.guarded(self._rest)
        if self.is_here:  # otherwise the worker is only out of jobs
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
    """Return all workers with a thread."""
    with _lock:
        return [*_at_work]


@atexit.register
def close_all() -> None:
    """Close all workers: threads in native code must not outlive Python."""
    workers = at_work()
    for worker in workers:  # all must end, before the first wait
        worker.close(0)
    end = time.monotonic() + _LAST_PATIENCE
    for worker in workers:
        worker.close(max(0.0, end - time.monotonic()))


if hasattr(os, "register_at_fork"):
    # The threads belong to the parent process, and one of them may have held the lock.
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
        """Compute something; pass the result to `take`, or None after an internal error."""

        def work() -> None:
            result = self._worker.guarded(compute)
            self._worker.post(lambda: done(result))

        def done(result: T | None) -> None:
            self._thread = None
            take(result)

        self._thread = threading.Thread(target=work, name=self._name, daemon=True)
        self._thread.start()

    def wait(self, timeout: float | None = None) -> None:
        """Wait for the end of the computation; any thread may call this (None = no timeout)."""
        if (thread := self._thread) is not None:
            thread.join(timeout)
