"""The age of a stream's frames, from its camera's time stamps."""

from __future__ import annotations

import math
from collections import deque

OLD = 0.1  # s above the freshest of late
_LATE = 10.0  # s of the stream
_IN_STEP = 2  # frames in a row: a busy machine reads one of a backlog late by chance
_MOST_STARTS = 3


class Freshness:
    """How much older each frame is than the freshest of the last 10 s of the stream.

    Its lag is the clock minus its stamp: an unknown constant, and the time for which it waited on
    its way. The window follows the stamps, and waits while a backlog is read, so that it
    outlasts a stall of any length.
    """

    def __init__(self) -> None:
        self._lags: deque[tuple[float, float]] = deque()  # (stamp, lag), each below the next one
        self._last: tuple[float, float] | None = None
        self._n_starts = self._n_in_step = 0

    def age(self, stamp: float, clock: float) -> float | None:
        """Return the age of the next frame (s); None if its stamp gives no age.

        Infinite at a start of the stamps while frames come faster than they were taken: a backlog,
        whose least lag is still to come. FFmpeg stamps the first two alike.
        """
        last, self._last = self._last, (stamp, clock)
        is_settled = self._n_in_step == _IN_STEP
        if last is None or stamp < last[0] or (stamp == last[0] and not is_settled):
            self._lags.clear()
            self._n_in_step = 0
            self._n_starts += 1
        else:
            is_in_step = clock - last[1] > (stamp - last[0]) / 2
            if not is_settled:
                self._n_in_step = self._n_in_step + 1 if is_in_step else 0
            self._add(stamp, clock - stamp, is_in_step)
        if self._n_in_step < _IN_STEP:
            return None if self._n_starts > _MOST_STARTS else math.inf
        self._n_starts = 0
        return clock - stamp - self._lags[0][1]

    def _add(self, stamp: float, lag: float, is_in_step: bool) -> None:
        while self._lags and self._lags[-1][1] >= lag:
            self._lags.pop()
        self._lags.append((stamp, lag))
        while is_in_step and self._lags[0][0] < stamp - _LATE:
            self._lags.popleft()
