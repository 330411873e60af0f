"""What the calling process of a campaign has to do for each row, whoever does the runs."""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

from robsim.bench._campaign.loops import KINDS, STEPS
from robsim.campaigns import campaign
from robsim.campaigns._engines.chunks import SECONDS
from robsim.campaigns._runs import Job, Row

_LARGE = 100  # runs of a chunk


class _Instant(Executor):
    """An executor whose runs take no time: what is handed over and back is packed, as by others."""

    def __init__(self, chunk: int) -> None:
        self._seconds = SECONDS / (chunk + 0.5)  # of a run, as its row says

    def submit(
        self, function: Callable[..., Any], /, *args: Any, **_: Any
    ) -> Future[Any]:  # what is asked for is not done
        jobs: list[Job] = pickle.loads(pickle.dumps((function, *args)))[2]
        rows = [Row(*job, None, None, self._seconds, {"metric": float(job[1])}) for job in jobs]
        future: Future[Any] = Future()
        future.set_result(pickle.loads(pickle.dumps(rows)))
        return future


def parent_cost(runs: int) -> tuple[float, float]:
    """Return the processor time that the calling process takes for a row, and for a chunk (s).

    Parameters
    ----------
    runs : int
        Number of runs of a campaign with large chunks; a tenth in chunks of one.
    """
    _seconds_of(10, 10)  # what is imported late
    large = _seconds_of(runs, _LARGE) / runs
    small = _seconds_of(runs // 10, 1) / (runs // 10)
    # small = row + chunk, large = row + chunk / n
    chunk = max(small - large, 0.0) / (1 - 1 / _LARGE)
    return max(large - chunk / _LARGE, 0.0), chunk


def _seconds_of(runs: int, chunk: int) -> float:
    spec: dict[str, Any] = {"metrics": {"metric": KINDS["no_frames"].metric}, "seed": 1}
    begin = time.process_time()
    campaign(
        KINDS["no_frames"].scenario,
        runs=runs,
        steps=STEPS,
        executor=_Instant(chunk),
        progress=False,
        **spec,
    )
    return time.process_time() - begin
