"""The runs of a campaign in chunks: large enough that handing them over costs little."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice

from robsim.campaigns.runs import Job, Row

SECONDS = 0.25  # of a chunk: what is lost when a worker, or the whole program, is killed
_FIRST, _MOST = 4, 500  # runs


def size_for(seconds: float, whole: float = SECONDS) -> int:
    """Return how many runs of a duration (s) make a chunk of another (s)."""
    return min(max(int(whole / max(seconds, 1e-9)), 1), _MOST)


class Chunks:
    """The `count` runs that are still to be done, in their order: case and number of each."""

    def __init__(self, jobs: Iterable[Job], count: int) -> None:
        self._jobs, self._left = iter(jobs), count
        self._runs, self._seconds = 0, 0.0

    def take(self, whole: float = SECONDS, room: int = 1) -> list[Job]:
        """Take the next chunk of `whole` seconds at most; empty = nothing is left.

        Near the end chunks are smaller, so that enough runs are left for `room` chunks at a time.
        """
        size = _FIRST
        if self._runs:
            each = self._seconds / self._runs
            size = max(size_for(each), min(size_for(each, whole), self._left // room))
        chunk = list(islice(self._jobs, size))
        self._left -= len(chunk)
        return chunk

    def note(self, rows: Sequence[Row]) -> None:
        """Learn from the rows of a chunk how long a run takes."""
        # What is long ago counts less: another case may take another time.
        self._runs = self._runs // 2 + len(rows)
        self._seconds = self._seconds / 2 + sum(row.seconds for row in rows)
