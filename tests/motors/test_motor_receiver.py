"""The rules of PROTOCOL.md, one by one, against the robot's end of a line."""

import os
import socket
import time

import numpy as np
import pytest

from motor_lines import Sender, drive_line, line, stop_line
from robsim.lab import LineError, MotorReceiver
from waiting import wait_for

pytestmark = pytest.mark.threads


@pytest.fixture
def robot():
    with MotorReceiver() as robot:
        yield robot


@pytest.fixture
def sender(robot):
    with Sender(robot.port) as sender:
        yield sender


def counts(robot):
    counts = robot.counts
    return counts.valid, counts.damaged, counts.old, counts.foreign


def heard(robot):
    return sum(counts(robot))


def say(robot, sender, *texts):
    """Send, and wait until all has been heard."""
    before = heard(robot)
    sender.send(*texts)
    wait_for(lambda: heard(robot) >= before + len(texts))


@pytest.mark.long
def test_what_is_no_line_changes_nothing(robot, sender):
    say(robot, sender, drive_line(1, 0.5, 0.5))
    texts = [
        drive_line(2).replace(b"1.0", b"3.0"),
        line("u 2 nan 2.0000 300"),
        line("a 2"),
        b"\xff\xfe\n",
        b"x" * 1500 + b"\n",
    ]
    for k, text in enumerate(texts):
        say(robot, sender, text)
        assert counts(robot) == (1, k + 1, 0, 0), text
    assert robot.input.tolist() == [0.5, 0.5]
    assert len(robot.events) == 1


def test_blank_lines_and_carriage_returns_mean_nothing(robot, sender):
    say(robot, sender, b"\n\n" + drive_line(1)[:-1] + b"\r\n\n")
    assert counts(robot) == (1, 0, 0, 0)


def test_a_datagram_holds_whole_lines(robot, sender):
    text = drive_line(1)
    sender.send(text[:10])  # no line ends in it: nothing to count
    say(robot, sender, text[10:], drive_line(2))
    assert counts(robot) == (1, 1, 0, 0)
    sender.send(drive_line(3) + drive_line(4, 3.0))
    wait_for(lambda: robot.counts.valid == 3)
    assert robot.input[0] == 3


@pytest.mark.long
def test_only_newer_lines_are_obeyed():
    for last, number, is_obeyed in (
        (10, 11, True),
        (10, 10, False),
        (10, 9, False),
        (10, 10 + 32767, True),
        (10, 10 + 32768, False),
        (65535, 0, True),
        (65535, 32767, False),
        (40000, 40000 + 32767 - 65536, True),
    ):
        with MotorReceiver() as robot, Sender(robot.port) as sender:
            say(robot, sender, drive_line(last, 1.0), drive_line(number, 2.0))
            assert robot.input[0] == (2 if is_obeyed else 1), (last, number)
            assert robot.counts.old == (not is_obeyed)


def test_an_older_input_does_not_start_a_stopped_robot(robot, sender):
    say(robot, sender, drive_line(10), stop_line(12), drive_line(11))
    assert robot.input.tolist() == [0, 0]
    assert [event.kind for event in robot.events] == ["input", "stop"]


def timed_out(robot):
    """Wait until it stops by itself; return its events up to there."""
    return wait_for(lambda: (events := robot.events)[-1].kind == "timeout" and events)


def test_it_stops_by_itself_when_the_time_to_live_is_over(robot, sender):
    say(robot, sender, drive_line(10, ttl=30))
    begin, end = timed_out(robot)
    assert end.t == pytest.approx(begin.t + 0.03, abs=1e-9)
    assert robot.mean(begin.t, end.t).tolist() == [1, 2]
    assert robot.mean(begin.t, begin.t + 0.06) == pytest.approx([0.5, 1])
    for wrong in (np.nan, np.inf, -np.inf):
        with pytest.raises(ValueError, match="start"):
            robot.mean(wrong, end.t)
        with pytest.raises(ValueError, match="end"):
            robot.mean(begin.t, wrong)
    assert robot.input.tolist() == [0, 0]


def test_what_it_ignores_does_not_count_as_heard(robot, sender):
    say(robot, sender, drive_line(10, ttl=50))

    def is_over():
        sender.send(drive_line(10, ttl=50), b"damaged\n")
        return len(robot.events) > 1

    wait_for(is_over)
    begin, end = robot.events[:2]
    assert end.kind == "timeout"
    assert end.t == pytest.approx(begin.t + 0.05, abs=1e-9)


def test_a_sender_that_starts_anew_is_obeyed_when_the_old_one_is_not_heard(robot, sender):
    say(robot, sender, drive_line(5000, ttl=40))
    timed_out(robot)
    with Sender(robot.port) as other:
        say(robot, other, drive_line(0, 3.0))
        assert robot.input[0] == 3
        assert other.answer() == line("a 0")


def test_other_senders_are_ignored_as_long_as_it_hears_one(robot, sender):
    with Sender(robot.port) as other:
        say(robot, sender, drive_line(1))
        say(robot, other, drive_line(2, 3.0))
        assert robot.input[0] == 1
        assert counts(robot) == (1, 0, 0, 1)


@pytest.mark.parametrize(("ttl", "is_obeyed"), [(30, True), (60000, False)])
def test_a_stop_counts_as_heard_for_its_time_to_live(robot, sender, ttl, is_obeyed):
    say(robot, sender, drive_line(10, ttl=30), stop_line(11, ttl))
    wait_for(lambda: time.monotonic() > robot.events[-1].t + 0.03)
    say(robot, sender, drive_line(3, 4.0))
    assert robot.input[0] == 4 * is_obeyed


def test_it_acts_later_by_the_delay_and_may_not_answer():
    with MotorReceiver(actuation_delay=500, answers=False) as robot, Sender(robot.port) as sender:
        say(robot, sender, drive_line(1, 1.0, 2.0))
        start = robot.events[0].t
        assert robot.input.tolist() == [0, 0]
        assert robot.mean(start + 499, start + 501) == pytest.approx([0.5, 1])
        robot.close()
        sender.socket.setblocking(False)
        with pytest.raises(BlockingIOError):
            sender.answer()


def test_a_stream_comes_in_any_pieces(rng):
    ours, its = socket.socketpair()
    with ours, its, MotorReceiver(descriptor=its.fileno()) as robot:
        text = b"".join(
            [
                b"left over*1234\n",
                drive_line(1),
                b"x" * 100 + drive_line(2),  # too long: one line
                drive_line(3)[:20] + b"\n",
                drive_line(4, 7.0),
            ]
        )
        cuts = np.sort(rng.integers(0, len(text), 12)).tolist()
        for start, end in zip([0, *cuts], [*cuts, len(text)], strict=True):
            ours.sendall(text[start:end])
        wait_for(lambda: robot.counts.valid == 2)
        assert counts(robot) == (2, 3, 0, 0)
        assert robot.input[0] == 7


def test_it_refuses_what_is_no_line(robot):
    with pytest.raises(LineError, match="another program"):
        MotorReceiver(robot.port)
    with pytest.raises(LineError, match="host"):
        MotorReceiver(host="999.1.2.3")
    with pytest.raises(LineError, match="descriptor"):
        MotorReceiver(descriptor=9999)
    with pytest.raises(ValueError, match="port"):
        MotorReceiver(65536)
    with pytest.raises(ValueError, match="actuation_delay"):
        MotorReceiver(actuation_delay=-1)


def test_the_descriptor_stays_the_callers():
    a, b = os.openpty()
    MotorReceiver(descriptor=a).close()
    os.write(a, b"x")  # still open
    os.close(a)
    os.close(b)
