"""Live runs from end to end, with and without faults."""

import itertools
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
import sessions
from python_devices import PATIENT, SteppedCamera
from robsim.lab import MotorReceiver, UdpMotors
from sizes import thorough
from surroundings import needs_double
from waiting import wait_for

with_proc = pytest.mark.skipif(
    not Path("/proc/self/task").is_dir(), reason="needs /proc and terminals"
)


# --- no faults


def test_a_robot_is_stopped_while_frames_stop_and_driven_when_they_return():
    images, poses = sessions.driven()
    source = SteppedCamera(itertools.cycle(images), permits=1)
    frames = SimpleNamespace(flow=True, seen={})

    def control(step):
        frames.seen[step.k] = step.frame.index
        if frames.flow:
            source.permits.release()
        return 1 + step.k / 100, 0.5

    def drive_on(steps):
        end = experiment.n_steps + steps
        while experiment.n_steps < end:
            try:
                experiment.run(end - experiment.n_steps)
            except TimeoutError:  # a busy machine
                source.permits.release()

    with (
        robsim.Camera(source, area=sessions.AREA, **PATIENT) as camera,
        MotorReceiver() as robot,
        UdpMotors("127.0.0.1", robot.port, ttl=60, hold=1000) as motors,
        robsim.Experiment(
            camera,
            send=motors,
            measure=True,
            control=control,
            frame_timeout=0.3,
        ) as experiment,
    ):
        drive_on(6)
        frames.flow = False
        with pytest.raises(TimeoutError, match="frame_timeout"):
            experiment.run(1000)
        wait_for(lambda: robot.events[-1].kind == "stop")
        stopped = robot.events[-1].t
        n = experiment.n_steps
        frames.flow = True
        source.permits.release()
        drive_on(6)
    trace = experiment.trace
    assert len(trace) == n + 6
    np.testing.assert_array_equal(trace.u, [(1 + k / 100, 0.5) for k in range(n + 6)])
    shown = [frames.seen[k] % len(poses) for k in range(n + 6)]
    np.testing.assert_allclose(trace.pose_measured, poses[shown], atol=1e-9)

    # The robot heard all of it, stood when no frame came, and stands.
    inputs = {round(event.u[0], 4): event.t for event in robot.events if event.kind == "input"}
    assert [*inputs] == trace.u[:, 0].round(4).tolist()
    assert inputs[round(1 + (n - 1) / 100, 4)] < stopped < inputs[round(1 + n / 100, 4)]
    assert robot.events[-1].kind == "stop"
    assert "timeout" not in {event.kind for event in robot.events}


# --- faults


ROUNDS = thorough(range(0, 60, 3), range(0, 60, 5))
ROUNDS_ON_WIRES = thorough((17, 21, 24, 35, 52), (17, 24, 35))  # what goes wrong with cameras
SLACK = 100  # s, by which a busy machine may be late
FRAMES = thorough(10_000, 4000)


def check(*words):
    path = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, "-m", *map(str, words)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@with_proc
def test_whatever_goes_wrong_the_robot_stands():
    pytest.importorskip("serial")
    check("live_faults", "--slack", SLACK, "--workers", 1, "--only", *ROUNDS)


@pytest.mark.slow
@with_proc
def test_whatever_goes_wrong_with_a_bus_or_a_server_the_robot_stands():
    pytest.importorskip("serial")
    needs_double("firewire")
    needs_double("gige")
    check(
        *("live_faults", "--slack", SLACK, "--workers", 1, "--cameras", "firewire", "gige"),
        *("--only", *ROUNDS_ON_WIRES),
    )


@pytest.mark.slow
@with_proc
def test_a_long_stream_needs_no_more_memory():
    check("live_faults.stream", "--frames", FRAMES)
