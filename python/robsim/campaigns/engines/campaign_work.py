"""The runs of a campaign as work for an engine, in chunks with a low transfer cost."""

from __future__ import annotations

import math
import pickle
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

from robsim.base.text import quoted, said_by
from robsim.campaigns.choices import Folder
from robsim.campaigns.runs import Job, Row, Worker
from robsim.campaigns.spec import CampaignSpec

SECONDS = 0.25  # of a chunk: the loss when a worker, or the whole program, is killed
_MOST = 500  # runs

#: The error of a run whose process dies.
DIED = "WorkerDied: the worker process ended in this run at each attempt"


@dataclass(frozen=True)
class CampaignWork:
    """The work of a campaign, as sent to its workers."""

    spec: CampaignSpec

    def doer(self) -> Callable[[Job], Row]:
        return Worker(self.spec).row

    def lost(self, job: Job, /) -> Row:
        return Row(*job, DIED, None, 0.0, {})


def check_can_be_sent(spec: CampaignSpec) -> None:
    """Raise TypeError for code that cannot be sent to other processes."""
    parts: list[tuple[str, object]] = [
        (f"vary: {name} {label!r}", choice)
        for name, choices in spec.vary.items()
        for label, choice in choices.items()
        if not isinstance(choice, Folder)  # plain texts
    ]
    parts += [(f"metrics: {name!r}", metric) for name, metric in spec._functions.items()]
    for what, value in parts:
        remedy = f"define it in a module, or give executor='threads'; got {quoted(value)}"
        try:
            content = pickle.dumps(value)
        except Exception as error:
            raise TypeError(
                f"{what} cannot be sent to other processes ({said_by(error)}): {remedy}"
            ) from error
        if b"__main__" in content and not hasattr(sys.modules["__main__"], "__file__"):
            raise TypeError(
                f"{what} belongs to a notebook or a prompt and cannot be sent to other processes: "
                f"{remedy}"
            )


def size_for(seconds: float) -> int:
    """Return the number of runs of a duration (s) in a chunk."""
    return min(max(int(SECONDS / max(seconds, 1e-9)), 1), _MOST)


class Chunks:
    """The remaining runs, in their order: case and number of each.

    This number of runs stays `together`.
    """

    def __init__(self, jobs: Iterable[Job], together: int = 1) -> None:
        self._jobs, self._size, self._together = iter(jobs), 1, together
        self._runs, self._seconds = 0, 0.0

    def take(self) -> list[Job]:
        """Take the next chunk; empty = no runs are left."""
        groups = math.ceil(self._size / self._together)
        return list(islice(self._jobs, groups * self._together))

    def note(self, rows: Sequence[Row]) -> None:
        """Learn from the rows of a chunk how many runs the next chunks may have."""
        # Old durations count less, because cases differ in duration.
        self._runs = self._runs // 2 + len(rows)
        self._seconds = self._seconds / 2 + sum(row.seconds for row in rows)
        self._size = size_for(self._seconds / self._runs)
