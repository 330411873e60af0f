"""Callbacks that remember their run, and therefore serve one run at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

_in_run: dict[int, object] = {}  # by their ids


@contextmanager
def held(callbacks: Iterable[object]) -> Iterator[None]:
    """Keep the callbacks that remember their run for the run of this thread.

    These are the objects with a true attribute ``_remembers_run``.

    Raises
    ------
    RuntimeError
        If another run has one of them.
    """
    run = object()
    mine = [one for one in callbacks if getattr(one, "_remembers_run", False) is True]
    try:
        for callback in mine:
            # One call, which no other thread interrupts.
            if _in_run.setdefault(id(callback), run) is not run:
                raise RuntimeError(
                    f"another run has this {type(callback).__name__}, which remembers where its "
                    "robot was: each simulation needs one of its own"
                )
        yield
    finally:
        for callback in mine:
            if _in_run.get(id(callback)) is run:
                del _in_run[id(callback)]
