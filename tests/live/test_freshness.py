"""A slow callback sees the newest frame: by numbers, not by a clock."""

import threading

import numpy as np
import pytest

import robsim
from python_cameras import PATIENT
from robsim.live import SimulatedLab
from robsim.motors import RecordedMotors
from threads import in_thread
from waiting import wait_for

SCENARIO = robsim.Scenario(area=(300, 300), resolution=(60, 60), seed=1)


@pytest.mark.long
@pytest.mark.threads
@pytest.mark.parametrize("is_busy", [False, True])
def test_a_slow_callback_gets_the_newest_frame(is_busy):
    newest, given, exposed = [], [], []
    is_over = threading.Event()

    def measure(step):
        given.append(step.frame.index)
        exposed.append(step.frame.epoch + step.frame.t)

    def control(step):
        wait_for(lambda: camera.counts.grabbed > given[-1] + 2)
        newest.append(camera.counts.grabbed - 1)  # what has come before the next one is asked for
        return 0.5, 0.2

    def keep_busy():
        while is_busy and not is_over.is_set():
            sum(range(1000))

    with SimulatedLab(SCENARIO, fps=100) as lab, robsim.Camera(lab, **PATIENT) as camera:
        with in_thread(keep_busy):
            try:
                robsim.Experiment(
                    camera,
                    send=RecordedMotors(),
                    measure=measure,
                    control=control,
                    frame_timeout=300,
                ).run(15)
            finally:
                is_over.set()
        truth = lab.truth
    assert all(index >= least for index, least in zip(given[1:], newest, strict=False))
    # By the lab's log each was exposed after those that were there before it was asked for.
    ticks = [int(np.argmin(abs(truth.t - truth.t[0] - (t - exposed[0])))) for t in exposed]
    assert (np.diff(ticks) >= np.diff(given)).all()
