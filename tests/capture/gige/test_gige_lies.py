"""Cameras on GigE Vision that say what is not so."""

import _thread
import signal
import struct
import threading
import time

import pytest

import robsim
from gige_between import DISCOVERY, LEADER, READ_MEMORY, URL, between
from gige_cameras import served
from robsim.capture import CaptureError

NAMES = slice(8 + 0x48, 8 + 0x88)  # vendor and model in an answer to a discovery


def announced(width, height):
    """Let frames tell another size than they have."""

    def sent(packet):
        if packet[4] & 0x7F != LEADER:
            return packet
        return packet[:24] + struct.pack(">II", width, height) + packet[32:]

    return sent


@pytest.mark.slow
@pytest.mark.sanitized
def test_names_that_are_no_utf8_are_shown():
    def answer(command, address, packet):
        if command != DISCOVERY:
            return packet
        return packet[: NAMES.start] + b"\xff\xe9" * 32 + packet[NAMES.stop :]

    with served(fps=10), between(answer), robsim.Camera(URL) as camera:
        assert camera.read().image.shape == (240, 320, 3)


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("size", [(2**31 - 1, 2**31 - 1), (2_000_000, 1000), (0, 0)])
def test_a_frame_that_is_smaller_than_it_tells(size):
    with (
        served(fps=10),
        between(sent=announced(*size)),
        pytest.raises(CaptureError, match="delivers what is no frame"),
    ):
        robsim.Camera(URL)


@pytest.mark.slow
def test_frames_that_no_memory_holds():
    # The camera's XML has a formula of the bytes of a frame.
    def answer(command, _, packet):
        if command != READ_MEMORY:
            return packet
        return packet[:12] + packet[12:].replace(b"* HEIGHT *", b"* 999999 *")

    with (
        served(fps=10),
        between(answer),
        pytest.raises(CaptureError, match="1 to 268435456 are read"),
    ):
        robsim.Camera(URL)


@pytest.fixture
def _interruptible():
    # A job in the background ignores it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.usefixtures("_interruptible")
def test_ctrl_c_ends_the_wait_for_a_camera_that_only_says_that_it_will_answer():
    # GigE Vision: PENDING_ACK, which asks for so many ms of patience.
    def answer(command, address, packet):
        if command == DISCOVERY:
            return packet
        return struct.pack(">HHH", 0, 0x89, 4) + packet[6:8] + struct.pack(">HH", 0, 65535)

    with served(fps=10), between(answer):
        threading.Timer(1.0, _thread.interrupt_main).start()
        begin = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            robsim.Camera(URL)
        assert time.monotonic() - begin < 20
