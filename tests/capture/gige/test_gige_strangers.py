"""GigE Vision: cameras that say what is not so, clients that ask for what there is not, garbage."""

import _thread
import random
import signal
import socket
import struct
import sys
import threading

import pytest

from gige_between import DISCOVERY, LEADER, READ_MEMORY, URL, between
from gige_cameras import ADDRESS, camera_of, driven, opened, served, ticks_of
from robsim.capture import CaptureError
from waiting import wait_for

PORT = 3956
KEY, WANTS_ANSWER = 0x42, 1
READ, WRITE, WRITE_MEMORY = 0x80, 0x82, 0x86
VENDOR = 0x48
# Registers of Aravis' fake camera, and of the protocol.
WIDTH, HEIGHT, PIXEL_FORMAT, ACQUISITION, PERIOD = 0x100, 0x104, 0x128, 0x124, 0x138
STREAM_PORT, PACKET_SIZE, STREAM_ADDRESS, CONTROL = 0xD00, 0xD04, 0xD18, 0xA00
DESCRIPTION = 0x200
BEYOND = (0xFFFE, 0x10000, 0x20000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFF0, 0xFFFFFFFF)
YUV_422 = 0x0210001F
NO_UTF8 = b"\xff\xe9" * 32


def datagrams():
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


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


def command(number, payload, size=None):
    size = len(payload) if size is None else size
    return struct.pack(">BBHHH", KEY, WANTS_ANSWER, number, size, 1) + payload


def write(address, value):
    return command(WRITE, struct.pack(">II", address, value))


def garbage():
    for address in BEYOND:
        for size in (1, 4, 512, 65535):
            yield command(READ_MEMORY, struct.pack(">IHH", address, 0, size))
        yield command(READ, struct.pack(">I", address))
        yield write(address, 0xFFFFFFFF)
    for address in (*BEYOND, DESCRIPTION, CONTROL):
        yield command(WRITE_MEMORY, struct.pack(">I", address) + b"A" * 512)
    yield write(CONTROL, 2)
    for address in (WIDTH, HEIGHT, PERIOD, PACKET_SIZE, DESCRIPTION):
        for value in (0, 1, 0xFFFFFFFF):
            if (address, value) not in ((WIDTH, 1), (HEIGHT, 1), (PERIOD, 1)):
                yield write(address, value)
    yield write(CONTROL, 0)
    generator = random.Random(1)
    for _ in range(2000):
        number = generator.choice((2, READ, READ_MEMORY, WRITE_MEMORY, 0x40, 0xFFFF))
        content = generator.randbytes(generator.choice((0, 1, 4, 8, 12, 600)))
        size = generator.choice((None, 0, generator.randrange(65536)))
        yield command(number, content, size)[: generator.choice((3, 8, 11, 1000))]
        yield generator.randbytes(generator.randrange(1000))


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.skipif(sys.platform != "linux", reason="the filter is one of Linux")
def test_whatever_comes_to_its_port_harms_no_server(server):
    with datagrams() as stream, datagrams() as client:
        stream.bind((ADDRESS, 0))
        client.connect((ADDRESS, PORT))
        client.settimeout(300)

        def write_register(address, value):
            client.send(write(address, value))
            assert client.recv(64)[:4] == struct.pack(">HH", 0, WRITE + 1)

        for address, value in (
            (CONTROL, 2),
            (STREAM_ADDRESS, int.from_bytes(socket.inet_aton(ADDRESS), "big")),
            (STREAM_PORT, stream.getsockname()[1]),
            (PACKET_SIZE, 1500),
            (PIXEL_FORMAT, YUV_422),
            (WIDTH, 31),  # of which this format has no rows
            (ACQUISITION, 1),
        ):
            write_register(address, value)
        sent, ticks = server.sent_frames, len(server.lab.truth)
        wait_for(lambda: len(server.lab.truth) > ticks + 20)
        assert server.sent_frames == sent
        for address, value in ((ACQUISITION, 0), (WIDTH, 320), (CONTROL, 0)):
            write_register(address, value)
    with datagrams() as sender:
        for one in garbage():
            sender.sendto(one, (ADDRESS, PORT))
    with camera_of(server) as camera:
        ticks_of(server, driven(server, camera, 3))
    assert not server.failure
