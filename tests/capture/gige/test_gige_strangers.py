"""GigE Vision: cameras that say what is not so."""

import _thread
import signal
import struct
import threading

import pytest

from gige_between import DISCOVERY, LEADER, READ_MEMORY, URL, between
from gige_cameras import opened, served
from robsim.lab import CaptureError

VENDOR = 0x48  # register
NO_UTF8 = b"\xff\xe9" * 32


def with_odd_names(command, address, packet):
    """A camera whose vendor and model are no UTF-8."""
    if command != DISCOVERY:
        return packet
    return packet[: 8 + VENDOR] + NO_UTF8 + packet[8 + VENDOR + len(NO_UTF8) :]


def announced(width, height):
    """Let frames tell another size than they have."""

    def sent(packet):
        if packet[4] & 0x7F != LEADER:
            return packet
        return packet[:24] + struct.pack(">II", width, height) + packet[32:]

    return sent


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("size", [(2**31 - 1, 2**31 - 1), (0, 0)])
def test_a_frame_that_is_smaller_than_it_tells(size):
    with (
        served(fps=10),
        between(with_odd_names, sent=announced(*size)),
        pytest.raises(CaptureError, match="no frame"),
    ):
        opened(URL)


@pytest.mark.slow
def test_frames_that_no_memory_holds():
    # The camera's XML has a formula of the bytes of a frame.
    def answer(command, _, packet):
        if command != READ_MEMORY:
            return packet
        return packet[:12] + packet[12:].replace(b"* HEIGHT *", b"* 999999 *")

    with served(fps=10), between(answer), pytest.raises(CaptureError, match="268435456"):
        opened(URL)


@pytest.mark.slow
def test_ctrl_c_ends_the_wait_for_a_camera_that_only_says_that_it_will_answer():
    # GigE Vision: PENDING_ACK, which asks for so many ms of patience.
    asked = threading.Event()

    def answer(command, address, packet):
        if command == DISCOVERY:
            return packet
        asked.set()
        return struct.pack(">HHH", 0, 0x89, 4) + packet[6:8] + struct.pack(">HH", 0, 65535)

    def interrupt():
        if asked.wait(300):
            _thread.interrupt_main()

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with served(fps=10), between(answer):
            thread = threading.Thread(target=interrupt)
            thread.start()
            with pytest.raises(KeyboardInterrupt):
                opened(URL)
            thread.join()
    finally:
        signal.signal(signal.SIGINT, before)
