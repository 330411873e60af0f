"""A campaign with many workers, simulated: when its calling process becomes the limit."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bench_campaign.parent import ParentCost

EACH = 2  # chunks of a worker in flight
_CHUNKS = 6  # of each of them in a simulation
_FEWEST = 1000  # chunks of a simulation
_WARM_UP = 0.25  # of its time, which does not count


class Throughput(NamedTuple):
    """What a simulated campaign reached.

    Attributes
    ----------
    rate : float
        Runs a second.
    parent, scheduler, workers : float
        Part of the time in which the calling process, the scheduler and a worker are busy, 0..1.
    """

    rate: float
    parent: float
    scheduler: float
    workers: float


def simulated(
    parent: ParentCost,
    scheduler: float,
    *,
    workers: int,
    chunk: int,
    seconds: float,
    spread: float = 0.5,
    seed: int = 1,
) -> Throughput:
    """Simulate a campaign event by event.

    Two chunks for each worker go round: to the scheduler, to a worker, back to the calling process,
    which takes all that are back, and hands as many new ones over.

    Parameters
    ----------
    parent : ParentCost
        What the calling process takes for a chunk and a row.
    scheduler : float
        What the scheduler takes for a chunk (s).
    workers, chunk : int
        Number of workers; runs of a chunk.
    seconds : float
        Mean duration of a run (s); the durations have a gamma distribution.
    spread : float
        Their standard deviation as a part of the mean; 0 = all are the same.
    seed : int
        Seed of the durations.
    """
    durations = _durations(chunk, seconds, spread, seed)
    return _Campaign(parent, scheduler, workers, chunk, durations).run(chunk * seconds)


def _durations(chunk: int, seconds: float, spread: float, seed: int) -> Iterator[float]:
    """Yield the durations of chunks (s)."""
    rng = np.random.default_rng(seed)
    while True:
        if not spread:
            yield chunk * seconds
            continue
        # The sum of n gamma variables of a scale has n times their shape.
        yield from rng.gamma(chunk / spread**2, seconds * spread**2, _FEWEST).tolist()


class _Campaign:
    """The state of a simulation."""

    def __init__(
        self,
        parent: ParentCost,
        scheduler: float,
        workers: int,
        chunk: int,
        durations: Iterator[float],
    ) -> None:
        self._parent, self._scheduler, self._chunk = parent, scheduler, chunk
        self._workers = self._idle = workers
        self._durations = durations
        self._events: list[tuple[float, int, int]] = []  # time, number, kind
        self._numbers = iter(range(10**9))
        self._waiting = self._back = 0  # chunks that wait for a worker, for the calling process
        self._is_parent_busy = False
        self._scheduler_until = 0.0
        self._kinds = (self._at_scheduler, self._at_worker, self._done, self._free)

    def run(self, duration: float) -> Throughput:
        """Simulate; the argument is the mean duration of a chunk (s)."""
        chunks = max(_FEWEST, _CHUNKS * EACH * self._workers)
        slowest = max(
            duration / self._workers,
            self._scheduler,
            self._parent.submit + self._parent.receive + self._chunk * self._parent.row,
        )
        self._end = chunks * slowest
        self._begin = _WARM_UP * self._end
        self._busy = dict.fromkeys(("parent", "scheduler", "workers"), 0.0)
        self._received = 0.0
        for _ in range(EACH * self._workers):
            self._push(0.0, 0)
        while self._events and self._events[0][0] < self._end:
            now, _, kind = heapq.heappop(self._events)
            self._kinds[kind](now)
        span = self._end - self._begin
        return Throughput(
            self._received * self._chunk / span,
            min(self._busy["parent"] / span, 1.0),  # but for what is rounded
            min(self._busy["scheduler"] / span, 1.0),
            min(self._busy["workers"] / span / self._workers, 1.0),
        )

    def _push(self, time: float, kind: int) -> None:
        heapq.heappush(self._events, (time, next(self._numbers), kind))

    def _note(self, who: str, since: float, until: float) -> float:
        """Note a time in which one is busy; return how much of it counts."""
        within = max(min(until, self._end) - max(since, self._begin), 0.0)
        self._busy[who] += within
        return within

    def _at_scheduler(self, now: float) -> None:
        begin = max(now, self._scheduler_until)
        self._scheduler_until = begin + self._scheduler
        self._note("scheduler", begin, self._scheduler_until)
        self._push(self._scheduler_until, 1)

    def _at_worker(self, now: float) -> None:
        if self._idle:
            self._idle -= 1
            self._start(now)
        else:
            self._waiting += 1

    def _start(self, now: float) -> None:
        until = now + next(self._durations)
        self._note("workers", now, until)
        self._push(until, 2)

    def _done(self, now: float) -> None:
        self._back += 1
        if self._waiting:
            self._waiting -= 1
            self._start(now)
        else:
            self._idle += 1
        if not self._is_parent_busy:
            self._wake(now)

    def _wake(self, now: float) -> None:
        """Let the calling process take all that is back, then hand over as much."""
        self._is_parent_busy = True
        count, self._back = self._back, 0
        time = now + self._parent.flying * EACH * self._workers
        time += count * (self._parent.receive + self._chunk * self._parent.row)
        for _ in range(count):
            time += self._parent.submit
            self._push(time, 0)
        within = self._note("parent", now, time)
        self._received += count * (within / (time - now) if time > now else now >= self._begin)
        self._push(time, 3)

    def _free(self, now: float) -> None:
        self._is_parent_busy = False
        if self._back:
            self._wake(now)
