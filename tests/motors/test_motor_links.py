"""Links to a robot over UDP and pseudo-terminals: they go on, stop, fail and end as promised."""

import gc
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import robsim
from motor_lines import example, line
from robsim.lab import (
    HaltedError,
    LineError,
    MotorReceiver,
    RecordedMotors,
    SerialMotors,
    UdpMotors,
)
from threads import forks, in_fork, in_thread
from waiting import LONGER_AND_LONGER, keep_interpreter, wait_for

pytestmark = [
    pytest.mark.long,
    pytest.mark.threads,
    pytest.mark.skipif(sys.platform == "win32", reason="made for Linux and macOS"),
]

SHORT = 0.06  # s, of what is repeated; on a busy machine the robot stops now and then
TTL = 60  # s


@pytest.fixture
def robot():
    with MotorReceiver() as robot:
        yield robot


def motors_of(robot, ttl=TTL, hold=1000):
    return UdpMotors("127.0.0.1", robot.port, ttl=ttl, hold=hold)


@pytest.fixture
def motors(robot):
    with motors_of(robot) as motors:
        yield motors


@pytest.fixture
def terminal():
    """A pseudo-terminal: the robot's end, the name of the other one."""
    pytest.importorskip("serial")
    master, slave = os.openpty()
    ends = {"robot": master, "cable": slave, "port": os.ttyname(slave)}
    yield ends
    for end in ("robot", "cable"):
        if ends[end] is not None:
            os.close(ends[end])


def cut(terminal):
    os.close(terminal["robot"])
    terminal["robot"] = None


def spin(step):
    return 1, -1


def kinds(thing):
    return [event.kind for event in thing.events]


def watched(motors, frame_timeout, record=None):
    """An experiment that has made a step: its watchdog waits for the next frame."""
    frame = robsim.Frame(np.zeros((64, 64, 3), np.uint8))
    options = {"area": (64, 64), "measure": False, "identify_from": "truth", "record": record}
    experiment = robsim.Experiment(
        [frame], send=motors, control=lambda step: (1, 1), frame_timeout=frame_timeout, **options
    )
    experiment.step()
    return experiment


def stop_of(thing):
    """When it was first told to stop."""
    return next((event.t for event in thing.events if event.kind == "stop"), np.inf)


def test_it_sends_and_says_when(robot, motors):
    before = time.monotonic()
    sent = motors((0.5, -0.25))
    assert before <= sent <= time.monotonic()
    wait_for(lambda: robot.input.tolist() == [0.5, -0.25])
    assert motors.events[0].t == sent
    assert kinds(robot) == ["input"]
    wait_for(lambda: len(motors.round_trip_times) > 0)
    assert (motors.round_trip_times > 0).all()


def test_a_robot_that_answers_no_more_is_told():
    answers, ended = threading.Event(), threading.Event()
    answers.set()

    def answer():
        while not ended.is_set():
            with suppress(TimeoutError):
                words, sender = end.recvfrom(2048)
                if answers.is_set():
                    end.sendto(line(f"a {words.split()[1].decode()}"), sender)

    def frames():
        yield frame
        wait_for(lambda: len(motors.round_trip_times) > 0)
        answers.clear()
        while not told:
            yield frame
        answers.set()
        wait_for(lambda: not motors.is_silent)
        yield frame

    frame = robsim.Frame(np.zeros((64, 64, 3), np.uint8))
    with (
        warnings.catch_warnings(record=True) as told,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end,
    ):
        warnings.simplefilter("always")
        end.bind(("127.0.0.1", 0))
        end.settimeout(0.05)
        port = end.getsockname()[1]
        with in_thread(answer), UdpMotors("127.0.0.1", port, ttl=SHORT, hold=1000) as motors:
            options = {"area": (64, 64), "measure": False, "frame_timeout": 300}
            experiment = robsim.Experiment(frames(), send=motors, control=spin, **options)
            trace = experiment.run()
            assert "silence" in kinds(motors)
            answers.clear()
            motors((1, -1))
            wait_for(lambda: motors.is_silent)
            motors.stop()
            wait_for(lambda: not motors.is_silent)
            ended.set()
    assert len(told) == 1
    assert motors.name in str(told[0].message)
    assert trace.unanswered.any()
    assert not trace.unanswered[[0, -1]].any()


def test_it_keeps_the_robot_going_while_python_does_something_else(robot):
    with motors_of(robot, ttl=0.3) as motors:
        motors((1, 1))
        wait_for(lambda: kinds(robot).count("input") > 6)
        assert kinds(motors).count("input") == 1
        heard = np.diff([event.t for event in robot.events if event.kind == "input"])
        assert "timeout" not in kinds(robot) or heard.max() >= 0.3
        assert robot.counts.old == 0


@pytest.mark.parametrize(
    ("holds", "is_recorded"),
    [
        (LONGER_AND_LONGER, False),
        (LONGER_AND_LONGER, True),
        pytest.param([16], True, marks=pytest.mark.slow),
    ],
    ids=["short", "short-recorded", "16 s-recorded"],
)
def test_the_watchdog_needs_no_interpreter(tmp_path, holds, is_recorded):
    if is_recorded:
        pytest.importorskip("cv2")
    for number, seconds in enumerate(holds):
        record = tmp_path / f"{number}.mcap" if is_recorded else None
        with MotorReceiver() as robot, motors_of(robot, ttl=SHORT) as motors:
            try:
                experiment = watched(motors, 0.1, record)
            except TimeoutError:  # a busy machine
                continue
            start = time.monotonic()
            keep_interpreter(seconds)
            end = time.monotonic()
            is_in_time = start < stop_of(motors) < end and start < stop_of(robot) < end
            if not is_in_time:
                continue
            assert "repeat" in kinds(motors)
            with pytest.raises(HaltedError, match="halted"):
                motors((1, 1))
            motors.resume()
            motors((2, 2))
            wait_for(lambda robot=robot: robot.input[0] == 2)
            experiment.stop_robot()
            experiment.__exit__(None, None, None)
            assert record is None or len(robsim.trace.Session(record)) == 1
            return
    pytest.fail("it did not stop the robot while the interpreter was kept")


def test_a_dropped_experiment_stops_its_robot(robot, motors):
    experiment = watched(motors, frame_timeout=300)
    assert "stop" not in kinds(motors)
    del experiment
    gc.collect()
    wait_for(lambda: kinds(robot)[-1] == "stop")


DRIVING = """
import os, signal, sys
from robsim.lab import UdpMotors
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background of a shell
motors = UdpMotors("127.0.0.1", int(sys.argv[1]), ttl=float(sys.argv[2]), hold=1000)
motors((1, 2))
print("drives", flush=True)
sys.stdin.read()
"""


def sending(code, robot, ttl=TTL):
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(robot.port), str(ttl)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "drives\n", process.stderr.read()
    return process


def test_the_robot_stops_by_itself_when_the_sender_is_killed(robot):
    with sending(DRIVING, robot, 0.1) as process:
        wait_for(lambda: robot.counts.valid > 5)
        process.send_signal(signal.SIGKILL)
        process.wait()
    *_, last, end = wait_for(lambda: (e := robot.events)[-1].kind == "timeout" and e)
    assert last.kind == "input"
    assert end.t == pytest.approx(last.t + 0.1, abs=1e-9)
    assert robot.mean(end.t, end.t + 1).tolist() == [0, 0]


@pytest.mark.parametrize("end", ["pass", "raise ValueError", "del motors; sys.stdin.read()"])
def test_the_end_of_the_program_stops_the_robot(robot, end):
    with sending(f"{DRIVING}\n{end}", robot) as process:
        _, errors = process.communicate(timeout=300)
        assert ("ValueError" in errors) == ("ValueError" in end)
    wait_for(lambda: kinds(robot)[-1] == "stop")


def test_ctrl_c_reaches_the_interpreter_and_stops_the_robot(robot):
    with sending(DRIVING, robot) as process:
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=300)
    assert errors.rstrip().endswith("KeyboardInterrupt")
    wait_for(lambda: kinds(robot)[-1] == "stop")


@forks
def test_a_forked_process_is_refused_in_words(robot, motors):
    experiment = watched(motors, frame_timeout=1000)

    def look():
        nonlocal experiment
        for use in (
            *(lambda: motors((1, 1)), motors.stop, motors.close),
            lambda: robot.input,
        ):
            with pytest.raises(RuntimeError, match="was opened in another process"):
                use()
        assert "closed" in repr(motors)
        assert "closed" in repr(robot)
        motors.halt()
        experiment = use = None
        gc.collect()

    in_fork(look)
    motors((3, 3))
    wait_for(lambda: robot.input[0] == 3)


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_threads_and_sockets_end_with_their_owners(robot):
    def held(kind):
        return set(os.listdir(f"/proc/self/{kind}"))

    threads, files = held("task"), held("fd")
    for _ in range(5):
        motors = motors_of(robot, ttl=SHORT)
        experiment = watched(motors, frame_timeout=1000)
        other = MotorReceiver()
        wait_for(lambda: len(held("task") - threads) == 3)  # others of the process come and go
        del motors, experiment, other
        gc.collect()
        wait_for(lambda: held("task") <= threads)
    assert len(held("fd")) <= len(files)
    wait_for(lambda: robot.input[0] == 0)


def test_a_robot_that_does_not_listen_is_told_by_name_and_driven_later():
    with MotorReceiver() as robot:
        port = robot.port
    motors = UdpMotors(f"127.0.0.1:{port}", ttl=SHORT)
    motors((1, 1))
    wait_for(lambda: "stop" in kinds(motors))  # it has seen that nobody is there
    with pytest.raises(LineError, match=rf"UDP 127\.0\.0\.1:{port} .*Connection refused"):
        motors((1, 1))
    with MotorReceiver(port) as robot:

        def is_told_to_stop():  # errors of before may have to be heard
            with suppress(LineError):
                motors.stop()
            return robot.counts.valid

        wait_for(is_told_to_stop)
        assert kinds(robot)[0] == "stop"
        motors((2, 2))
        wait_for(lambda: robot.input[0] == 2)
        motors.close()
        wait_for(lambda: robot.input[0] == 0)


def drives_at_once():
    """Whether a robot that is switched on later can be driven with the first input."""
    with MotorReceiver() as robot:
        port = robot.port
    motors = UdpMotors("127.0.0.1", port, ttl=TTL)
    with suppress(LineError):
        motors((1, 1))
    with suppress(LineError):
        motors.stop()
    wait_for(lambda: len(motors.events) >= 6)  # nothing hears the last of the quick stops, either
    with MotorReceiver(port) as robot, suppress(LineError):
        motors((1, 2))
        wait_for(lambda: robot.counts.valid)
        motors.close()
        return True
    return False


def test_what_became_of_a_stop_is_no_matter_of_an_input():
    # On a busy machine an answer of the system may come late, which is one.
    assert any(drives_at_once() for _ in range(10))


def test_an_error_at_the_end_of_a_block_is_told():
    def use(error):
        with MotorReceiver() as robot, motors_of(robot, ttl=SHORT) as motors:
            motors((1, 1))
            robot.close()
            wait_for(lambda: "stop" in kinds(motors))
            if error:
                raise error

    with pytest.raises(KeyError) as raised:
        use(KeyError("mine"))
    assert "UDP" in raised.value.__notes__[0]
    with pytest.raises(LineError, match="nothing listens"):
        use(None)


def test_serial_motors_drive_a_robot(terminal):
    with (
        MotorReceiver(descriptor=terminal["robot"]) as robot,
        SerialMotors(terminal["port"], ttl=SHORT, hold=1000) as motors,
    ):
        motors((0.5, -0.25))
        wait_for(lambda: robot.input.tolist() == [0.5, -0.25])
        wait_for(lambda: len(motors.round_trip_times) > 3)
        with pytest.raises(LineError, match="another program"):
            SerialMotors(terminal["port"])
        motors.close()
        wait_for(lambda: robot.input[0] == 0)
        assert "stop" in kinds(robot)
        assert robot.counts.damaged == 0
        with SerialMotors(terminal["port"]) as again:  # once the first one was not heard for long
            wait_for(lambda: again((1, 1)) and robot.input[0] == 1)


def test_a_cut_cable_is_told_by_name(terminal):
    motors = SerialMotors(terminal["port"], ttl=SHORT, hold=1000)
    motors((1, 1))
    cut(terminal)
    wait_for(lambda: "failure" in kinds(motors))
    with pytest.raises(LineError, match=rf"serial line {terminal['port']} "):
        motors((1, 1))
    n = kinds(motors).count("failure")
    wait_for(lambda: kinds(motors).count("failure") >= n + 4)  # stop is tried again
    with pytest.raises(LineError):
        motors.close()
    motors.close()


def test_a_line_that_nobody_reads_does_not_block(terminal):
    motors = SerialMotors(terminal["port"], ttl=SHORT, hold=1000)
    with pytest.raises(LineError, match="50 ms"):
        wait_for(lambda: motors((1, 1)) and False)
    cut(terminal)
    with pytest.raises(LineError):
        motors.close()


def test_what_cannot_be_opened_is_told_with_a_remedy(monkeypatch):
    pytest.importorskip("serial")
    with pytest.raises(LineError, match="cable"):
        SerialMotors("/dev/robsim-nothing")
    with pytest.raises(LineError, match="host"):
        UdpMotors("999.1.2.3:5")
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(LineError, match="Linux and macOS"):
        SerialMotors("COM3")
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ImportError, match=r"pip install 'robsim\[serial\]'"):
        SerialMotors("/dev/robsim-nothing")


def test_what_is_out_of_range_is_refused():
    for address in ("robot", "robot:", ":5", "robot:x", "[::1]", "", "robot:-1"):
        with pytest.raises(ValueError, match="address"):
            UdpMotors(address)
    for name, value in (("ttl", 0.029), ("ttl", 60.1), ("hold", 0), ("port", 0), ("port", 65536)):
        with pytest.raises(ValueError, match=name):
            UdpMotors("127.0.0.1", **{"port": 9, name: value})
    for ttl in (0.03, 60):
        UdpMotors("127.0.0.1", 9, ttl=ttl).close()


def test_an_input_that_is_refused_leaves_the_robot_driving(robot, motors):
    motors((1, 1))
    for u in ((np.nan, 0), (1,), (1000, 0)):
        with pytest.raises(ValueError, match="u"):
            motors(u)
    wait_for(lambda: robot.input[0] == 1)


def test_the_python_robot_of_the_page_obeys():
    robot = {}
    exec(example("python"), robot)
    driven = []
    is_over = threading.Event()
    with MotorReceiver() as free:
        port = free.port
    listen = lambda: robot["listen"](port, lambda *u: driven.append(u), is_over.is_set)  # noqa: E731
    with in_thread(listen):
        try:
            with UdpMotors("127.0.0.1", port, ttl=SHORT, hold=1000) as motors:

                def is_obeyed():
                    try:
                        motors((0.5, -0.25))
                    except LineError:  # it does not listen yet
                        return False
                    return len(motors.round_trip_times) > 0

                wait_for(is_obeyed)
                wait_for(lambda: driven[-1] == (0.5, -0.25))
            wait_for(lambda: driven[-1] == (0, 0))
        finally:
            is_over.set()


def test_recorded_motors_keep_what_came():
    with RecordedMotors() as motors:
        times = [motors((0.5, -0.25)), motors(np.array([1, 2])), motors.stop()]
        assert motors.inputs.tolist() == [[0.5, -0.25], [1, 2], [0, 0]]
        assert motors.times.tolist() == times == sorted(times)
    assert motors.inputs[-1].tolist() == [0, 0]
    assert len(motors.times) == 4
    with pytest.raises(LineError, match="closed"):
        motors((1, 1))
    assert RecordedMotors().inputs.shape == (0, 2)
