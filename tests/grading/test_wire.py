"""Messages over a socket: lengths and kinds are checked before anything is read."""

import os
import signal
import socket
import struct
import sys
import threading
import time

import numpy as np
import pytest

from graded import HONEST
from robsim import RobotModel
from robsim.teach.grading._wire import LIMITS, Channel, Kind, Ready, WireError

HEAD = struct.Struct("<HHI")
MINUTES = 300.0  # s


@pytest.fixture
def ends():
    one, other = socket.socketpair()
    with one, other:
        yield Channel(one, LIMITS), other


@pytest.fixture(params=["receive", "exchange", "exchange by Python"])
def heard(request):
    """A function that waits for the next message, alone or after a question."""

    def ask(channel, patience):
        if request.param == "receive":
            return channel.receive(patience)
        if request.param == "exchange by Python":
            channel._native = None
        return channel.exchange(Kind.STEP, b"question", patience=patience)

    return ask


@pytest.fixture
def ctrl_c():
    """Let it raise KeyboardInterrupt, also where Python was started so that it ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt(other):
    """Press Ctrl-C when a message has come here; by a thread."""

    def press():
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        other.recv(100)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    return thread


def test_a_message_of_several_parts_comes_as_one(ends):
    channel, other = ends
    channel.send(Kind.STEP, b"ab", np.arange(3, dtype=np.uint8).data)
    assert other.recv(100) == HEAD.pack(Kind.STEP, 0, 5) + b"ab\0\1\2"
    other.send(HEAD.pack(Kind.ANSWER, 0, 2) + b"no")
    pixels = np.arange(3, dtype=np.uint8).reshape(1, 3)
    assert channel.exchange(Kind.STEP, b"ab", pixels.data) == (Kind.ANSWER, b"no")
    assert other.recv(100) == HEAD.pack(Kind.STEP, 0, 5) + b"ab\0\1\2"


def test_a_channel_that_is_closed_speaks_no_more(ends):
    channel, _ = ends
    channel.close()
    with pytest.raises(OSError, match=r"descriptor|10038"):
        channel.exchange(Kind.STEP, b"ab", patience=MINUTES)


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.skipif(sys.platform == "win32", reason="there a signal ends no exchange")
@pytest.mark.parametrize("by_another_thread", [False, True])
def test_ctrl_c_ends_an_exchange(ends, by_another_thread):
    channel, other = ends
    blocked = [signal.SIGINT] if by_another_thread else []
    before = signal.pthread_sigmask(signal.SIG_BLOCK, blocked)  # so that it interrupts no call
    try:
        thread = interrupt(other)
        with pytest.raises(KeyboardInterrupt):
            channel.exchange(Kind.STEP, b"ab", patience=MINUTES)
        thread.join()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def test_a_large_message_comes_whole(ends):
    channel, other = ends
    body = bytes(range(256)) * 20_000
    sender = threading.Thread(target=Channel(other).send, args=(Kind.HELLO, body))
    sender.start()
    assert Channel(channel._socket).receive(MINUTES) == (Kind.HELLO, body)
    sender.join()


def test_a_message_in_pieces_comes_whole(ends, heard):
    channel, other = ends
    message = HEAD.pack(Kind.ANSWER, 0, 3) + b"abc"

    def drip():
        for i in range(len(message)):
            time.sleep(0.002)
            other.send(message[i : i + 1])

    sender = threading.Thread(target=drip)
    sender.start()
    assert heard(channel, MINUTES) == (Kind.ANSWER, b"abc")
    sender.join()


def test_what_is_no_message_that_is_due_is_refused(heard):
    for message in (
        HEAD.pack(Kind.ANSWER, 0, 1 << 31),
        HEAD.pack(Kind.ANSWER, 0, LIMITS[Kind.ANSWER] + 1),
        HEAD.pack(Kind.ANSWER, 1, 0),
        HEAD.pack(99, 0, 0),
        HEAD.pack(Kind.HELLO, 0, 0),
        HEAD.pack(Kind.ANSWER, 0, 1) + b"ab",
        HEAD.pack(Kind.ANSWER, 0, 0) * 2,
    ):
        one, other = socket.socketpair()
        with one, other:
            other.send(message)
            with pytest.raises(WireError):
                heard(Channel(one, LIMITS), MINUTES)


def test_a_connection_that_is_closed_is_told(ends, heard):
    channel, other = ends
    other.send(HEAD.pack(Kind.ANSWER, 0, 10) + b"abc")
    other.shutdown(socket.SHUT_WR)
    with pytest.raises(EOFError, match="in the middle"):
        heard(channel, MINUTES)


def test_half_a_message_is_waited_for_as_long_as_a_whole_one(ends, heard):
    channel, other = ends
    other.send(HEAD.pack(Kind.ANSWER, 0, 10) + b"abc")
    with pytest.raises(TimeoutError):
        heard(channel, 0.05)


def test_readiness_comes_back_as_it_was_and_what_cannot_be_is_refused():
    slots = tuple(HONEST)
    ready = Ready(("define_model", "control"), ("measure",), True, RobotModel())
    assert Ready.from_bytes(ready.to_bytes(slots), slots) == ready
    for place, value, error in (
        (0, struct.pack("<I", 1 << 6), WireError),
        (4, struct.pack("<I", 1 << 6), WireError),
        (8, struct.pack("<I", 2), WireError),
        (12, struct.pack("<d", 0), ValueError),
        (12, struct.pack("<d", np.nan), ValueError),
        (20, struct.pack("<d", np.nan), ValueError),
        (20, struct.pack("<d", 5.0), ValueError),
        (140, b"x", WireError),
    ):
        body = bytearray(ready.to_bytes(slots))
        body[place : place + len(value)] = value
        with pytest.raises(error):
            Ready.from_bytes(bytes(body), slots)
