"""Links to a robot over UDP and pseudo-terminals: they go on, stop, fail and end as promised."""

import ctypes
import gc
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import robsim
import sanitizers
from motor_lines import example
from robsim._core import Watchdog
from robsim.motors import (
    HaltedError,
    LineError,
    MotorReceiver,
    RecordedMotors,
    SerialMotors,
    UdpMotors,
)
from threads import in_thread, together
from waiting import wait_for

pytestmark = [
    pytest.mark.long,
    pytest.mark.threads,
    pytest.mark.skipif(sys.platform == "win32", reason="made for Linux and macOS"),
]

TTL = 0.06  # s


@pytest.fixture
def robot():
    with MotorReceiver() as robot:
        yield robot


@pytest.fixture
def motors(robot):
    with UdpMotors("127.0.0.1", robot.port, ttl=TTL, hold=1000) as motors:
        yield motors


@pytest.fixture
def terminal():
    """A pseudo-terminal: the robot's end, the name of the other one."""
    master, slave = os.openpty()
    ends = {"robot": master, "cable": slave, "port": os.ttyname(slave)}
    yield ends
    for end in ("robot", "cable"):
        if ends[end] is not None:
            os.close(ends[end])


def cut(terminal):
    os.close(terminal["robot"])
    terminal["robot"] = None


def kinds(thing):
    return [event.kind for event in thing.events]


def native_threads():
    return len(list(Path("/proc/self/task").iterdir()))


def descriptors():
    return len(list(Path("/proc/self/fd").iterdir()))


needs_proc = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")


def test_it_sends_and_says_when(robot, motors):
    before = time.monotonic()
    sent = motors((0.5, -0.25))
    assert before <= sent <= time.monotonic()
    wait_for(lambda: robot.input.tolist() == [0.5, -0.25])
    assert motors.events[0].t == sent
    assert kinds(robot)[0] == "input"
    wait_for(lambda: len(motors.round_trip_times) > 0)
    assert (motors.round_trip_times > 0).all()


def test_it_keeps_the_robot_going_while_python_does_something_else(robot):
    # With time enough that a busy machine is no time-out.
    with UdpMotors("127.0.0.1", robot.port, ttl=0.5, hold=1000) as motors:
        motors((1, 1))
        wait_for(lambda: len(robot.events) > 8)
        assert set(kinds(robot)) == {"input"}
        assert kinds(motors).count("input") == 1
        assert robot.counts.old == 0


def test_stop_is_told_again_and_again(robot, motors):
    motors((1, 1))
    motors.stop()
    wait_for(lambda: kinds(motors).count("stop") >= 8)
    wait_for(lambda: robot.input[0] == 0)
    assert "timeout" not in kinds(robot)


def test_it_stops_the_robot_where_no_input_follows(robot):
    with UdpMotors("127.0.0.1", robot.port, ttl=TTL, hold=0.1) as motors:
        sent = motors((1, 1))
        wait_for(lambda: "stop" in kinds(robot))
        assert next(event.t for event in motors.events if event.kind == "stop") >= sent + 0.1


def test_the_watchdog_needs_no_interpreter(robot, motors):
    sleep = ctypes.PyDLL(None).usleep  # holds the interpreter's lock
    watchdog = Watchdog(motors)
    watchdog.arm(0.1)
    motors((1, 1))
    start = time.monotonic()
    sleep(400_000)
    end = time.monotonic()
    first = next(event.t for event in motors.events if event.kind == "stop")
    assert start < first < end
    heard = next(event.t for event in robot.events if event.kind == "stop")
    assert start < heard < end
    assert "repeat" in kinds(motors)
    assert watchdog.has_expired
    with pytest.raises(HaltedError, match="was halted: it takes no input before resume"):
        motors((1, 1))
    assert repr(motors).endswith("halted>")
    motors.resume()
    motors((2, 2))
    wait_for(lambda: robot.input[0] == 2)
    watchdog.disarm()


def test_a_watchdog_that_is_fed_lets_the_robot_drive(robot, motors):
    watchdog = Watchdog(motors)
    watchdog.arm(10)
    for _ in range(20):
        watchdog.feed(time.monotonic())
        motors((1, 1))
    assert not watchdog.has_expired
    watchdog.disarm()
    assert "stop" not in kinds(motors)


KILLED = """
import os, signal, sys
from robsim.motors import UdpMotors
motors = UdpMotors("127.0.0.1", int(sys.argv[1]), ttl=0.1, hold=1000)
motors((1, 2))
print("drives", flush=True)
sys.stdin.read()
"""


def sending(code, robot, **options):
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(robot.port)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )
    assert process.stdout.readline() == "drives\n", process.stderr.read()
    return process


def test_the_robot_stops_by_itself_when_the_sender_is_killed(robot):
    with sending(KILLED, robot) as process:
        wait_for(lambda: robot.counts.valid > 5)
        process.send_signal(signal.SIGKILL)
        process.wait()
    wait_for(lambda: kinds(robot)[-1] == "timeout")
    *_, last, end = robot.events
    assert last.kind == "input"
    assert end.t == pytest.approx(last.t + 0.1, abs=1e-9)
    assert robot.mean(end.t, end.t + 1).tolist() == [0, 0]


@pytest.mark.parametrize(
    "end", ["pass", "raise ValueError", "sys.exit(3)", "del motors; sys.stdin.read()"]
)
def test_the_end_of_the_program_stops_the_robot(robot, end):
    with sending(f"{KILLED}\n{end}", robot) as process:
        _, errors = process.communicate(timeout=60)
        assert ("ValueError" in errors) == ("ValueError" in end)
    wait_for(lambda: kinds(robot)[-1] == "stop")
    assert "timeout" not in kinds(robot)


def test_ctrl_c_reaches_the_interpreter_and_stops_the_robot(robot):
    # What a shell starts in the background ignores Ctrl-C.
    hears = "signal.signal(signal.SIGINT, signal.default_int_handler)\nmotors = "
    code = KILLED.replace("motors = ", hears, 1)
    code = code.replace("sys.stdin.read()", "import time; time.sleep(60)")
    with sending(code, robot) as process:
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
    assert errors.rstrip().endswith("KeyboardInterrupt")
    wait_for(lambda: kinds(robot)[-1] == "stop")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.skipif(sanitizers.ADDRESS or sanitizers.THREAD, reason="forks beside threads")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_is_refused_in_words(robot, motors):
    motors((1, 1))
    watchdog = Watchdog(motors)
    watchdog.arm(1000)
    child = os.fork()
    if child == 0:
        told = []
        for use in (
            lambda: motors((1, 1)),
            motors.stop,
            motors.close,
            lambda: robot.input,
            lambda: watchdog.arm(1),
        ):
            try:
                use()
            except RuntimeError as error:
                told.append("was opened in another process" in str(error))
        told.append("closed" in repr(motors) and "closed" in repr(robot))
        motors.halt()
        watchdog.disarm()
        del watchdog, use
        gc.collect()
        os._exit(0 if told == [True] * 6 else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    watchdog.disarm()
    motors((3, 3))
    wait_for(lambda: robot.input[0] == 3)


@pytest.mark.slow
@pytest.mark.sanitized
@needs_proc
def test_threads_and_sockets_end_with_their_owners(robot):
    time.sleep(0.05)  # those of the test before may still be on their way out
    gc.collect()
    threads, files = native_threads(), descriptors()
    for _ in range(5):
        motors = UdpMotors("127.0.0.1", robot.port, hold=1000)
        motors((1, 1))
        watchdog = Watchdog(motors)
        watchdog.arm(1000)
        other = MotorReceiver()
        assert native_threads() == threads + 3
        del motors, watchdog, other
        gc.collect()
    wait_for(lambda: native_threads() == threads)
    assert descriptors() <= files  # another test's may have gone meanwhile
    wait_for(lambda: robot.input[0] == 0)


def test_a_robot_that_does_not_listen_is_told_by_name():
    with MotorReceiver() as robot:
        port = robot.port
    motors = UdpMotors(f"127.0.0.1:{port}", ttl=TTL)
    motors((1, 1))
    told = rf"UDP 127\.0\.0\.1:{port} .*: Connection refused: nothing listens there"
    wait_for(lambda: "stop" in kinds(motors))  # it has seen that nobody is there
    with pytest.raises(LineError, match=told):
        motors((1, 1))
    with MotorReceiver(port) as robot:
        wait_for(lambda: robot.counts.valid > 0)
        assert kinds(robot)[0] == "stop"
        while True:  # errors of before may have to be heard
            try:
                motors((2, 2))
                break
            except LineError:
                pass
        wait_for(lambda: robot.input[0] == 2)
        motors.close()
        wait_for(lambda: robot.input[0] == 0)


def test_an_error_at_the_end_of_a_block_is_told(robot):
    port = robot.port

    def use(error):
        with UdpMotors(f"127.0.0.1:{port}", ttl=TTL, hold=1000) as motors:
            motors((1, 1))
            robot.close()
            wait_for(lambda: "stop" in kinds(motors))
            if error:
                raise error

    with pytest.raises(KeyError) as raised:
        use(KeyError("mine"))
    assert "when the line to the robot was closed: UDP" in raised.value.__notes__[0]
    with pytest.raises(LineError, match="nothing listens there"):
        use(None)


def test_serial_motors_drive_a_robot(terminal):
    pytest.importorskip("serial")
    with (
        MotorReceiver(descriptor=terminal["robot"]) as robot,
        SerialMotors(terminal["port"], ttl=TTL, hold=1000) as motors,
    ):
        motors((0.5, -0.25))
        wait_for(lambda: robot.input.tolist() == [0.5, -0.25])
        wait_for(lambda: len(motors.round_trip_times) > 3)
        with pytest.raises(LineError, match="another program has opened it"):
            SerialMotors(terminal["port"])
        assert repr(motors) == f"<SerialMotors '{terminal['port']}', ttl=0.06>"
        motors.close()
        wait_for(lambda: robot.input[0] == 0)
        assert robot.counts.damaged == 0
        assert "timeout" not in kinds(robot)
        with SerialMotors(terminal["port"]) as again:  # once the first one was not heard for long
            wait_for(lambda: again((1, 1)) and robot.input[0] == 1)


def test_a_cut_cable_is_told_by_name(terminal):
    pytest.importorskip("serial")
    motors = SerialMotors(terminal["port"], ttl=TTL, hold=1000)
    motors((1, 1))
    cut(terminal)
    wait_for(lambda: "failure" in kinds(motors))
    with pytest.raises(LineError, match=rf"serial line {terminal['port']} "):
        motors((1, 1))
    n = kinds(motors).count("failure")
    wait_for(lambda: kinds(motors).count("failure") >= n + 5)  # stop is tried again
    with pytest.raises(LineError):
        motors.close()
    motors.close()


def test_a_line_that_nobody_reads_does_not_block(terminal):
    pytest.importorskip("serial")
    motors = SerialMotors(terminal["port"], ttl=TTL, hold=1000)

    def fill():
        while True:
            motors((1, 1))

    with pytest.raises(LineError, match="took no line within 50 ms: does nobody read"):
        fill()
    cut(terminal)
    with pytest.raises(LineError):
        motors.close()


def test_what_cannot_be_opened_is_told_with_a_remedy(monkeypatch):
    pytest.importorskip("serial")
    with pytest.raises(LineError, match="there is no such device; is the cable plugged in"):
        SerialMotors("/dev/robsim-nothing")
    with pytest.raises(LineError, match="there is no such host"):
        UdpMotors("999.1.2.3:5")
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(LineError, match="made for Linux and macOS"):
        SerialMotors("COM3")
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ImportError, match=r"pip install 'robsim\[serial\]'"):
        SerialMotors("/dev/robsim-nothing")


@pytest.mark.parametrize("address", ["robot", "robot:", ":5", "robot:x", "[::1]", "", "robot:-1"])
def test_an_address_that_is_none_is_refused(address):
    with pytest.raises(ValueError, match="address must"):
        UdpMotors(address)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"ttl": 0.01}, r"ttl must lie within 0\.03\.\.60"),
        ({"ttl": 61}, r"ttl must lie within 0\.03\.\.60"),
        ({"hold": 0}, "hold must be finite and above 0"),
        ({"port": 0}, r"port must lie within 1\.\.65535"),
        ({"port": 65536}, r"port must lie within 1\.\.65535"),
    ],
)
def test_options_out_of_range_are_refused(options, told):
    with pytest.raises(ValueError, match=told):
        UdpMotors("127.0.0.1", **{"port": 9, **options})


def test_inputs_that_are_none_are_refused_and_the_robot_goes_on(robot, motors):
    motors((1, 1))
    for u in ((np.nan, 0), (1,), "ab", (1000, 0)):
        with pytest.raises((TypeError, ValueError), match="u"):
            motors(u)
    wait_for(lambda: robot.input[0] == 1)


def test_it_serves_several_threads(robot, motors):
    end = time.monotonic() + 0.1

    def again(call):
        def work():
            while time.monotonic() < end:
                call()

        return work

    together(
        again(lambda: motors((1, 1))),
        again(lambda: motors((2, 2))),
        again(motors.stop),
        again(lambda: motors.events),
        again(lambda: robot.mean(0, time.monotonic())),
    )
    motors.close()
    wait_for(lambda: robot.input[0] == 0)
    assert robot.counts.damaged == robot.counts.foreign == 0


def test_the_interpreter_goes_on_while_a_line_is_written(terminal):
    pytest.importorskip("serial")
    motors = SerialMotors(terminal["port"], ttl=TTL, hold=1000)
    switches = []
    is_over = threading.Event()

    def count():
        while not is_over.is_set():
            switches.append(time.monotonic())
            time.sleep(0.001)

    refused = False
    with in_thread(count):
        while not refused:
            start = time.monotonic()
            try:
                motors((1, 1))
            except LineError:
                refused = True
        end = time.monotonic()
        is_over.set()
    assert len([t for t in switches if start < t < end]) > 3
    cut(terminal)
    with pytest.raises(LineError):
        motors.close()


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
            with UdpMotors("127.0.0.1", port, ttl=TTL, hold=1000) as motors:

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
        assert repr(motors) == "<RecordedMotors, 3 inputs>"
    assert motors.inputs[-1].tolist() == [0, 0]
    assert len(motors.times) == 4
    with pytest.raises(LineError, match="closed"):
        motors((1, 1))
    assert RecordedMotors().inputs.shape == (0, 2)


def test_an_experiment_drives_a_robot_at_the_end_of_a_line(robot, motors):
    frames = [robsim.Frame(np.zeros((60, 60, 3), np.uint8), t=0.2 * k) for k in range(5)]
    with robsim.Experiment(frames, send=motors, measure=None, area=(60, 60)) as experiment:
        experiment.control = lambda step: (1 + step.k, 1)
        experiment.run()
    sent = [event.u[0] for event in motors.events if event.kind == "input"]
    assert sent == [1, 2, 3, 4, 5]
    wait_for(lambda: robot.input[0] == 0)
    assert re.match(r"<UdpMotors '127\.0\.0\.1:\d+', ttl=0\.06>", repr(motors))


def test_a_robot_that_is_switched_on_later_is_driven():
    with MotorReceiver() as robot:
        port = robot.port
    motors = UdpMotors("127.0.0.1", port, ttl=TTL)
    motors((1, 1))
    time.sleep(0.1)  # it is refused, and stops
    with pytest.raises(LineError, match="nothing listens there"):
        motors((1, 1))
    time.sleep(0.1)  # nothing hears this, either
    with MotorReceiver(port) as robot:
        motors((1, 2))  # what became of the stop is no matter of this one
        wait_for(lambda: robot.counts.valid)
        motors.close()
