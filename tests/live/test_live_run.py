"""Live runs from end to end, with and without faults."""

import contextlib
import itertools
import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gige_cameras
import robsim
import sessions
from python_devices import PATIENT, SteppedCamera
from robsim.lab import MotorReceiver, SimulatedLab, UdpMotors, UnpluggedError
from sizes import thorough
from surroundings import needs_double, needs_extension
from threads import running
from waiting import LONGER_AND_LONGER, keep_interpreter, wait_for

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


@contextlib.contextmanager
def simulated_lab():
    """A lab, and its camera."""
    with (
        SimulatedLab(robsim.Scenario(seed=1, resolution=(200, 200)), fps=100) as lab,
        robsim.Camera(lab, **PATIENT) as camera,
    ):
        yield lab, camera


@contextlib.contextmanager
def gige_camera():
    """A lab whose frames come by Aravis."""
    needs_extension("gige")
    with (
        gige_cameras.alone(),
        gige_cameras.served() as server,
        gige_cameras.camera_of(server) as camera,
    ):
        yield server.lab, camera


@pytest.fixture
def greedy():
    """A thread that has the interpreter keeps it until it waits for something."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(300)
    yield
    sys.setswitchinterval(before)


@pytest.mark.threads
@pytest.mark.usefixtures("greedy")
@pytest.mark.parametrize("source", [simulated_lab, gige_camera])
def test_a_run_without_callbacks_goes_on_while_nobody_gets_the_interpreter(source):
    with source() as (lab, camera), UdpMotors(lab.address, ttl=60, hold=1000) as motors:
        experiment = robsim.Experiment(
            camera,
            send=motors,
            control=robsim.DriveAround(),
            measure=True,
            estimate_parameters=True,
            frame_timeout=300,
        )
        with running(experiment):
            for seconds in LONGER_AND_LONGER:
                start = experiment.trace.t_sent.size
                epoch = camera.newest.epoch
                begin = time.monotonic()
                keep_interpreter(seconds)
                end = time.monotonic()
                time.sleep(0)
                sent = experiment.trace.t_sent[start:] + epoch
                if ((sent > begin) & (sent < end)).sum() > 5:
                    break
            else:
                pytest.fail("the run stood still while the interpreter was held")


CTRL_C = """
import robsim
import _thread, signal, threading

# A shell's background ignores Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
lab = robsim.lab.SimulatedLab(robsim.Scenario(seed=1, resolution=(64, 64)))
camera, motors = robsim.Camera(lab), robsim.lab.UdpMotors(lab.address)
experiment = robsim.Experiment(
    camera, send=motors, control=robsim.DriveAround(), measure=False, frame_timeout=300
)
def interrupt():
    while not experiment.n_steps:
        pass
    _thread.interrupt_main()
threading.Thread(target=interrupt, daemon=True).start()
try:
    experiment.run()
except KeyboardInterrupt:
    print("interrupted", experiment.is_running, motors.events[-1].kind)
"""


def test_ctrl_c_ends_a_run_that_is_alone_and_stops_the_robot():
    done = subprocess.run(
        [sys.executable, "-c", CTRL_C],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("interrupted False stop\n", "")


def test_what_ends_a_camera_reaches_the_user_with_the_step():
    with simulated_lab() as (lab, camera), UdpMotors(lab.address) as motors:
        experiment = robsim.Experiment(
            camera, send=motors, control=robsim.DriveAround(), measure=False, frame_timeout=300
        )
        experiment.run(3)
        lab.unplug()
        with pytest.raises(UnpluggedError) as raised:
            experiment.run()
        assert raised.value.__notes__ == [f"in frames at step {experiment.n_steps}"]
        assert motors.events[-1].kind == "stop"
        camera.close()
        with pytest.raises(ValueError, match="closed"):
            experiment.run()


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
