"""What takes long: computed beside the thread of the view, which goes on answering."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from robsim.gui._worker import Worker

T = TypeVar("T")


class Beside:
    """Computes one thing at a time, in a thread that ends with it.

    Parameters
    ----------
    worker : Worker
        In its thread the results are taken.
    name : str
        That of the thread.
    """

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
