"""The runs of a campaign in chunks: large enough that handing them over costs little."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from robsim.campaigns._runs import Job, Row

_SECONDS = 0.25  # of a chunk: what is lost when a worker, or the whole program, is killed
_FIRST, _MOST = 4, 500  # runs


class Chunks:
    """The runs that are still to be done, in their order."""

    def __init__(self, jobs: Iterable[Job]) -> None:
        self._jobs = deque(jobs)
        self._runs, self._seconds = 0, 0.0

    def take(self) -> list[Job]:
        """Take the next chunk; empty = nothing is left."""
        size = _FIRST
        if self._runs:
            size = int(_SECONDS * self._runs / max(self._seconds, 1e-9))
        size = min(max(size, 1), _MOST, len(self._jobs))
        return [self._jobs.popleft() for _ in range(size)]

    def note(self, rows: Sequence[Row]) -> None:
        """Learn from the rows of a chunk how long a run takes."""
        # What is long ago counts less: another case may take another time.
        self._runs = self._runs // 2 + len(rows)
        self._seconds = self._seconds / 2 + sum(row.seconds for row in rows)
