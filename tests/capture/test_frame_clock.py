"""The times of frames that arrive late by chance: when they were exposed."""

import numpy as np
import pytest

import robsim
from python_cameras import PATIENT, SteppedCamera
from robsim.capture import EndOfStream

DT = 1 / 30
START = 1000.0  # s


class LateCamera(SteppedCamera):
    """Delivers frames that arrived at given times, each when the one before was taken."""

    def __init__(self, arrivals, dt):
        super().__init__([])
        self.arrivals = list(arrivals)
        self.dt = dt
        self.sent, self.taken = 0, 0

    def read(self):
        if self.taken < self.sent:
            return None
        if self.sent == len(self.arrivals):
            raise EndOfStream("over")
        self.sent += 1
        return np.zeros((4, 4, 3), np.uint8), None, self.arrivals[self.sent - 1], 0, 0


@pytest.mark.long
@pytest.mark.parametrize("dt", [None, DT])
def test_frames_that_come_late_now_and_then(dt):
    rng = np.random.default_rng(1)
    exposed = START + DT * np.arange(600)
    late = np.where(np.arange(600) % 40 == 39, 0.6 * DT, rng.exponential(0.001, 600))
    source, found = LateCamera(exposed + late, dt), []
    with robsim.Camera(source, **PATIENT) as camera:
        for frame in camera:
            found.append(frame.epoch + frame.t)
            source.taken += 1
    error = (found - exposed) / DT
    # Arrivals of 0.6 intervals late must not shift those behind them.
    assert abs(np.median(error)) < 0.05
    assert np.abs(error[60:]).max() < 0.3
