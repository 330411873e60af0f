"""What engines do: jobs of some work, handed out in chunks, each of which gives a row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

JobT = TypeVar("JobT")
RowT = TypeVar("RowT")
_Given = TypeVar("_Given", contravariant=True)


class Doer(Protocol[_Given, RowT]):
    """What does jobs, one after the other."""

    def rows(self, jobs: Sequence[_Given], /) -> list[RowT]:
        """Return the rows of some jobs."""


class Work(Protocol[_Given, RowT]):
    """All that jobs have in common: a value that is sent to those who do them."""

    def doer(self) -> Doer[_Given, RowT]:
        """Return what does jobs, where it is wanted."""

    def lost(self, job: _Given, /) -> RowT:
        """Return the row of a job whose process ends, whenever it is tried."""

    def check_can_be_sent(self) -> None:
        """Raise TypeError for what other processes cannot be sent."""


class Supply(Protocol[JobT, _Given]):
    """The jobs that are still to be done."""

    def take(self, whole: float = ..., room: int = ...) -> list[JobT]:
        """Take the next chunk, of `whole` seconds at most, where there may be `room` at a time.

        Empty = no chunk is there, or not yet.
        """

    def note(self, rows: Sequence[_Given], /) -> None:
        """Be told of the rows of a chunk."""


def rows_of(work: Work[JobT, RowT], jobs: list[JobT]) -> list[RowT]:
    """Return the rows of some jobs: what an executor calls."""
    return work.doer().rows(jobs)
