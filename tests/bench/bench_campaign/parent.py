"""What the calling process of a campaign takes for a chunk and a row, whoever does the runs."""

from __future__ import annotations

import pickle
import tempfile
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any, NamedTuple

from bench_campaign.loops import KINDS, STEPS
from robsim.campaigns import campaign
from robsim.campaigns.engines.campaign_work import SECONDS
from robsim.campaigns.runs import Job, Row

_LARGE = 100  # runs of a chunk
_MANY = 200  # workers


class ParentCost(NamedTuple):
    """Processor time of the calling process (s).

    Attributes
    ----------
    submit, receive : float
        To hand a chunk over; to take one back and commit it to the store.
    row : float
        For each row of a chunk.
    flying : float
        For each chunk in flight, whenever the process wakes up because some are done.
    """

    submit: float
    receive: float
    row: float
    flying: float


class _Elsewhere(Executor):
    """An executor whose runs take no time; the oldest chunk is done when all workers have two.

    What is handed over and back is packed, as by others; what they would do of it themselves is
    not counted. The specification is not packed: a cluster is sent it once.
    """

    def __init__(self, runs: int, chunk: int, workers: int) -> None:
        self._max_workers = workers  # by which a campaign chooses how many chunks are in flight
        self._left = runs
        self._seconds = SECONDS / (chunk + 0.5)  # of a run, as its row says
        self._flying: deque[tuple[Future[Any], bytes]] = deque()
        self.chunks = self.waits = 0
        self.submitting = self.elsewhere = 0.0

    def submit(
        self, function: Callable[..., Any], /, *args: Any, **_: Any
    ) -> Future[Any]:  # what is asked for is not done
        begin = time.process_time()
        pickle.dumps((function, *args[1:]))
        sent = time.process_time()
        jobs: list[Job] = pickle.loads(args[1])
        rows = [Row(*job, None, None, self._seconds, {"metric": float(job[1])}) for job in jobs]
        future: Future[Any] = Future()
        self._flying.append((future, pickle.dumps(rows)))
        self.chunks += 1
        self.submitting += sent - begin
        self.elsewhere += time.process_time() - sent
        self._left -= len(jobs)
        if len(self._flying) == 2 * self._max_workers:
            self.waits += 1
            self._end_one()
        while not self._left and self._flying:
            self._end_one()
        return future

    def _end_one(self) -> None:
        future, rows = self._flying.popleft()
        future.set_result(pickle.loads(rows))


def parent_cost(runs: int) -> ParentCost:
    """Return what the calling process takes, by campaigns whose runs are not done.

    Parameters
    ----------
    runs : int
        Number of runs of a campaign with large chunks; a tenth in chunks of one.
    """
    _timed(10, 10, 1)  # what is imported late
    large, _ = _timed(runs, _LARGE, 1)
    small, executor = _timed(max(runs // 10, 1), 1, 1)
    submit = executor.submitting / executor.chunks
    # small = row + chunk, large = row + chunk / n
    each = max(small - large, 0.0) / (1 - 1 / _LARGE)
    row = max(large - each / _LARGE, 0.0)
    n_runs = 4 * (2 * _MANY + runs // 20)
    few, _ = _timed(n_runs, 4, 1)
    many, executor = _timed(n_runs, 4, _MANY)
    flying = max(many - few, 0.0) * n_runs / (executor.waits * 2 * _MANY)
    return ParentCost(submit, max(each - submit, 0.0), row, flying)


def _timed(runs: int, chunk: int, workers: int) -> tuple[float, _Elsewhere]:
    """Return the processor time for a run (s), and the executor."""
    executor = _Elsewhere(runs, chunk, workers)
    with tempfile.TemporaryDirectory() as folder:
        begin = time.process_time()
        campaign(
            KINDS["no_frames"].scenario,
            metrics={"metric": KINDS["no_frames"].metric},
            runs=runs,
            steps=STEPS,
            seed=1,
            executor=executor,
            store=Path(folder, "store.sqlite"),
            progress=False,
        )
        took = time.process_time() - begin
    return (took - executor.elsewhere) / runs, executor
