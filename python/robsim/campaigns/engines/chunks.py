"""The runs of a campaign in chunks: large enough that handing them over costs little."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice

from robsim.campaigns.runs import Job, Row

SECONDS = 0.25  # of a chunk: what is lost when a worker, or the whole program, is killed
_MOST = 500  # runs


def size_for(seconds: float) -> int:
    """Return how many runs of a duration (s) make a chunk."""
    return min(max(int(SECONDS / max(seconds, 1e-9)), 1), _MOST)


class Chunks:
    """The runs that are still to be done, in their order: case and number of each."""

    def __init__(self, jobs: Iterable[Job]) -> None:
        self._jobs, self._size = iter(jobs), 1
        self._runs, self._seconds = 0, 0.0

    def take(self) -> list[Job]:
        """Take the next chunk; empty = nothing is left."""
        return list(islice(self._jobs, self._size))

    def note(self, rows: Sequence[Row]) -> None:
        """Learn from the rows of a chunk how many runs the next ones may have."""
        # What is long ago counts less: another case may take another time.
        self._runs = self._runs // 2 + len(rows)
        self._seconds = self._seconds / 2 + sum(row.seconds for row in rows)
        self._size = size_for(self._seconds / self._runs)
