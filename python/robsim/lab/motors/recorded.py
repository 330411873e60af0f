"""Motors that record their inputs."""

from __future__ import annotations

import time
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import LineError
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted
from robsim.base.values import Closing


class RecordedMotors(Closing):
    """Motors that drive nothing and record their inputs, for rehearsals and tests.

    Examples
    --------
    >>> motors = robsim.lab.RecordedMotors()
    >>> sent_at = motors((0.5, -0.25))
    >>> motors.inputs
    array([[ 0.5 , -0.25]])
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._sent: list[tuple[float, float, float]] = []
        self._is_closed = False

    def __call__(self, u: ArrayLike) -> float:
        """Record an input, and return its time.

        Parameters
        ----------
        u : array (2,)
            Voltages of the left and the right motor (V).

        Returns
        -------
        float
            Time of the input (s, clock of time.monotonic).

        Raises
        ------
        robsim.lab.LineError
            After `close`.
        """
        values = as_float_array("u", u)
        if values.shape != (2,) or not np.isfinite(values).all():
            raise ValueError(f"u must be (u1, u2), finite, in V, got {quoted(u)}")
        if self._is_closed:
            raise LineError("the recorded motors were closed")
        return self._keep(float(values[0]), float(values[1]))

    def stop(self) -> float:
        """Record an input of 0, 0, and return its time (s, clock of time.monotonic)."""
        return self._keep(0.0, 0.0)

    def close(self) -> None:
        """Stop, and refuse further inputs; a second call does nothing."""
        if not self._is_closed:
            self._is_closed = True
            self.stop()

    @property
    def inputs(self) -> Floats:
        """Array (N, 2): the recorded inputs (V); a stop is recorded as 0, 0."""
        return np.array([sent[1:] for sent in self._sent]).reshape(-1, 2)

    @property
    def times(self) -> Floats:
        """Array (N,): the times of the inputs (s, clock of time.monotonic)."""
        return np.array([sent[0] for sent in self._sent], dtype=np.float64)

    @property
    def is_closed(self) -> bool:
        """bool: True after `close`."""
        return self._is_closed

    def _keep(self, u1: float, u2: float) -> float:
        with self._lock:  # the times increase
            now = time.monotonic()
            self._sent.append((now, u1, u2))
        return now

    def __repr__(self) -> str:
        n = len(self._sent)
        return f"<RecordedMotors, {n} input{'' if n == 1 else 's'}{', closed' * self._is_closed}>"
