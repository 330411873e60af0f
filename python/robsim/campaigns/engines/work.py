"""The work of engines: jobs, submitted in chunks; each job gives a row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

JobT = TypeVar("JobT")
RowT = TypeVar("RowT")
_Given = TypeVar("_Given", contravariant=True)
_Made = TypeVar("_Made", covariant=True)


class Work(Protocol[_Given, _Made]):
    """The common part of all jobs: a value sent to the workers."""

    def doer(self) -> Callable[[_Given], _Made]:
        """Return a function that does jobs, one after the other."""

    def lost(self, job: _Given, /) -> _Made:
        """Return the row of a job whose process ends at each attempt."""


class Supply(Protocol[JobT, _Given]):
    """The remaining jobs."""

    def take(self) -> list[JobT]:
        """Take the next chunk; empty = no jobs now."""

    def note(self, rows: Sequence[_Given], /) -> None:
        """Receive the rows of a chunk."""
