"""GigE Vision: what no camera of Aravis says, and no client of its asks, by our own datagrams."""

import contextlib
import socket
import struct
import threading

import pytest

from gige_cameras import ADDRESS, camera_of, driven, served, ticks_of
from needs import needs_extension

pytestmark = pytest.mark.long

PORT = 3956
KEY, WANTS_ANSWER = 0x42, 1
DISCOVERY, WRITE = 2, 0x82
VENDOR, MODEL, SERIAL = 0x48, 0x68, 0xD8
# Registers of Aravis' fake camera, and of the protocol.
WIDTH, PIXEL_FORMAT, ACQUISITION = 0x100, 0x128, 0x124
STREAM_PORT, PACKET_SIZE, STREAM_ADDRESS, CONTROL = 0xD00, 0xD04, 0xD18, 0xA00
YUV_422 = 0x0210001F


@contextlib.contextmanager
def answering(registers):
    """Be a camera that answers each discovery with its first registers."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera:
        camera.bind((ADDRESS, PORT))
        camera.settimeout(0.1)
        ends = threading.Event()

        def answer():
            while not ends.is_set():
                with contextlib.suppress(TimeoutError):
                    question, asker = camera.recvfrom(1024)
                    head = struct.pack(">HHH", 0, DISCOVERY + 1, len(registers)) + question[6:8]
                    camera.sendto(head + registers, asker)

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            yield
        finally:
            ends.set()
            thread.join()


def test_names_that_are_no_utf8_are_told_all_the_same():
    registers = bytearray(0xF8)
    registers[0x24:0x28] = socket.inet_aton(ADDRESS)
    for place, text in ((VENDOR, "Müller".encode("latin-1")), (MODEL, b"\xff\xfe"), (SERIAL, b"7")):
        registers[place : place + len(text)] = text
    with answering(bytes(registers)):
        found = needs_extension("gige").find_cameras(0.3)
    assert {"vendor": "M\ufffdller", "model": "\ufffd\ufffd", "serial": "7"}.items() <= next(
        one for one in found if one["address"] == ADDRESS
    ).items()


def write_register(client, address, value):
    client.send(struct.pack(">BBHHHII", KEY, WANTS_ANSWER, WRITE, 8, 1, address, value))
    assert client.recv(64)[:4] == struct.pack(">HH", 0, WRITE + 1)


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_client_that_asks_for_what_there_is_not_harms_nobody():
    with served() as server:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stream,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client,
        ):
            stream.bind((ADDRESS, 0))
            stream.settimeout(5)
            client.connect((ADDRESS, PORT))
            client.settimeout(5)
            for address, value in (
                (CONTROL, 2),
                (STREAM_ADDRESS, int.from_bytes(socket.inet_aton(ADDRESS), "big")),
                (STREAM_PORT, stream.getsockname()[1]),
                (PACKET_SIZE, 1500),
                (PIXEL_FORMAT, YUV_422),
                (WIDTH, 31),  # of which this format has no rows
                (ACQUISITION, 1),
            ):
                write_register(client, address, value)
            sent = server.sent_frames
            threading.Event().wait(0.3)
            assert server.sent_frames == sent
            write_register(client, ACQUISITION, 0)
            write_register(client, WIDTH, 320)
            write_register(client, CONTROL, 0)
        assert server.failure is None
        with camera_of(server) as camera:
            ticks_of(server, driven(server, camera, 3))
