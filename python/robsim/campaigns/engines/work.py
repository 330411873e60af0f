"""What engines do: jobs of some work, handed out in chunks, each of which gives a row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

JobT = TypeVar("JobT")
RowT = TypeVar("RowT")
_Given = TypeVar("_Given", contravariant=True)
_Made = TypeVar("_Made", covariant=True)


class Work(Protocol[_Given, _Made]):
    """All that jobs have in common: a value that is sent to those who do them."""

    def doer(self) -> Callable[[_Given], _Made]:
        """Return what does jobs, one after the other."""

    def lost(self, job: _Given, /) -> _Made:
        """Return the row of a job whose process ends, whenever it is tried."""


class Supply(Protocol[JobT, _Given]):
    """The jobs that are still to be done."""

    def take(self) -> list[JobT]:
        """Take the next chunk; empty = none is there, or not yet."""

    def note(self, rows: Sequence[_Given], /) -> None:
        """Be told of the rows of a chunk."""
