"""Messages and arrays over a socket: checked first, read later."""

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
from robsim.teach.grading.arrays import as_array, as_arrays, from_message, to_parts

# --- messages


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


# --- arrays


def message(*arrays):
    return b"".join(bytes(part) for part in to_parts(as_arrays("array", arrays)))


def test_arrays_come_as_they_were_sent():
    sent = {
        "f8": [
            0.5,
            [1.0, np.nan, -np.inf],
            np.arange(6, dtype=">f4").reshape(2, 3).T,
            [],
            [[]] * 3,
        ],
        "i8": [7, [[1, 2], [3, 4]], np.array([2**63 - 1], np.uint64)],
        "u1": [True, np.arange(24, dtype=np.uint8).reshape(2, 3, 4)],
    }
    for dtype, values in sent.items():
        came = from_message(message(*values))
        assert len(came) == len(values)
        for one, value in zip(came, values, strict=True):
            np.testing.assert_array_equal(one, np.asarray(value))
            assert (one.dtype, one.shape) == (np.dtype(dtype), np.shape(value))
            assert one.flags.writeable
            assert one.flags.owndata
    assert from_message(message()) == []


def test_what_is_no_array_of_real_numbers_is_refused():
    assert as_array("x", np.zeros((1, 1, 1))).ndim == 3
    for value, error in (
        ("text", TypeError),
        (1j, TypeError),
        ([[1, 2], [3]], ValueError),
        (np.zeros((1, 1, 1, 1)), ValueError),
        (np.array([2**63], np.uint64), ValueError),
    ):
        with pytest.raises(error, match=r"\bx\b"):
            as_array("x", value)


def test_too_much_is_refused():
    assert len(as_arrays("argument", [0] * 16)) == 16
    with pytest.raises(ValueError, match="16 arguments are allowed, got 17"):
        as_arrays("argument", [0] * 17)
    whole = np.broadcast_to(np.uint8(0), 64 << 20)
    as_arrays("argument", [whole])
    with pytest.raises(ValueError, match=r"arguments .* 64 MiB"):
        as_arrays("argument", [whole, [1]])


def test_bytes_that_are_none_are_refused():
    for body in (
        b"",
        b"abc",
        struct.pack("<I", 1),
        struct.pack("<I", 17) + bytes(17 * 26),
        struct.pack("<I", 2**32 - 1),
        struct.pack("<IBB3Q", 1, 3, 0, 0, 0, 0),
        struct.pack("<IBB3Q", 1, 2, 4, 0, 0, 0),
        struct.pack("<IBB3Q", 1, 2, 1, 5, 0, 0) + bytes(4),
        struct.pack("<IBB3Q", 1, 2, 1, 5, 0, 0) + bytes(6),
        struct.pack("<IBB3Q", 1, 0, 3, 2**63, 2**63, 2**63) + bytes(8),
        struct.pack("<IBB3Q", 1, 0, 3, 2**63, 2**63, 0),
        struct.pack("<IBB3Q", 1, 0, 3, 0, 2**62, 2**62),
    ):
        with pytest.raises(ValueError, match=r"^(an array|arrays)"):
            from_message(body)


def test_random_bytes_are_taken_or_refused(rng):
    good = message([1.5, 2.5], [[3]], np.arange(4, dtype=np.uint8))
    taken = 0
    for _ in range(2000):
        body = bytearray(good)
        for _ in range(rng.integers(1, 4)):
            body[rng.integers(len(body))] ^= 1 << rng.integers(8)
        try:
            arrays = from_message(bytes(body[: len(body) - (rng.random() < 0.1)]))
        except ValueError:
            continue
        taken += 1
        assert sum(array.nbytes for array in arrays) <= len(good)
    assert 100 < taken < 1900
