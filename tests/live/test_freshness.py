"""A slow callback sees the newest frame: by numbers, not by a clock."""

import threading
import time

import numpy as np
import pytest

import robsim
from robsim.live import SimulatedLab
from robsim.motors import RecordedMotors

pytestmark = pytest.mark.long

FPS = 100
SCENARIO = robsim.Scenario(area=(300, 300), resolution=(60, 60), seed=1)


@pytest.mark.threads
@pytest.mark.parametrize("is_busy", [False, True])
def test_a_slow_callback_gets_the_newest_frame(is_busy):
    newest, given, exposed = [], [], []
    is_over = threading.Event()

    def measure(step):
        given.append(step.frame.index)
        exposed.append(step.frame.epoch + step.frame.t)

    def control(step):
        time.sleep(2.5 / FPS)
        newest.append(camera.counts.grabbed - 1)  # what has come before the next one is asked for
        return 0.5, 0.2

    def keep_busy():
        while not is_over.is_set():
            sum(range(1000))

    other = threading.Thread(target=keep_busy)
    with SimulatedLab(SCENARIO, fps=FPS) as lab, robsim.Camera(lab) as camera:
        if is_busy:
            other.start()
        try:
            robsim.Experiment(
                camera, send=RecordedMotors(), measure=measure, control=control, frame_timeout=60
            ).run(25)
        finally:
            is_over.set()
        truth = lab.truth
    if is_busy:
        other.join()
    assert all(index >= least for index, least in zip(given[1:], newest, strict=False))
    assert np.mean(np.diff(given)) > 1.5  # it was slow
    # By the lab's log each was exposed after those that were there before it was asked for.
    ticks = [int(np.argmin(abs(truth.t - truth.t[0] - (t - exposed[0])))) for t in exposed]
    assert (np.diff(ticks) >= np.diff(given)).all()
