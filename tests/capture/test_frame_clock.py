"""The times of frames that arrive late by chance: when they were exposed."""

import numpy as np
import pytest

import robsim
from robsim import _core
from robsim.capture import EndOfStream

pytestmark = pytest.mark.long

DT = 1 / 30
START = 1000.0  # s


class LateCamera:
    """Delivers frames that arrived at given times."""

    def __init__(self, arrivals, dt):
        self._arrivals = list(arrivals)
        self.dt = dt
        self._next = 0
        self.taken = -1

    def _open_device(self):
        return _core.PythonCamera(self)

    def open(self):
        pass

    def close(self):
        pass

    def read(self):
        if self.taken < self._next - 1:
            return None  # until the one before is taken
        if self._next == len(self._arrivals):
            raise EndOfStream("over")
        self._next += 1
        return np.zeros((4, 4, 3), np.uint8), None, self._arrivals[self._next - 1], 0, 0


def times(arrivals, dt=None):
    """Return the times of frames that arrived at these times (s)."""
    source = LateCamera(arrivals, dt)
    found = []
    with robsim.Camera(source, frame_timeout=60) as camera:
        for frame in camera:
            found.append(frame.epoch + frame.t)
            source.taken = frame.index
    return np.array(found)


@pytest.mark.parametrize("dt", [None, DT])
def test_frames_that_come_late_now_and_then(dt):
    rng = np.random.default_rng(1)
    exposed = START + DT * np.arange(600)
    late = np.where(np.arange(600) % 40 == 39, 0.6 * DT, rng.exponential(0.001, 600))
    error = (times(exposed + late, dt) - exposed) / DT
    # Arrivals of 0.6 intervals late must not shift those behind them.
    assert abs(np.median(error)) < 0.05
    assert np.abs(error[60:]).max() < 0.3
