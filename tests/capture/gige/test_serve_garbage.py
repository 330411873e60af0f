"""A camera that is served goes on, whatever comes to the port of its control protocol."""

import random
import socket
import struct
import sys

import pytest

import robsim
from gige_cameras import ADDRESS, served

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="the filter is one of Linux"),
]

PORT = 3956
READ_REGISTER, WRITE_REGISTER, READ_MEMORY, WRITE_MEMORY = 0x80, 0x82, 0x84, 0x86
CONTROL, PACKET_SIZE, DESCRIPTION = 0xA00, 0xD04, 0x200
BEYOND = (0xFFFE, 0x10000, 0x20000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFF0, 0xFFFFFFFF)


def packet(command, payload, size=None):
    return struct.pack(">BBHHH", 0x42, 1, command, len(payload) if size is None else size, 1) + (
        payload
    )


def reads_of_memory():
    for address in BEYOND:
        for size in (1, 4, 512, 65535):
            yield packet(READ_MEMORY, struct.pack(">IHH", address, 0, size))


def registers():
    for address in BEYOND:
        yield packet(READ_REGISTER, struct.pack(">I", address))
        yield packet(WRITE_REGISTER, struct.pack(">II", address, 0xFFFFFFFF))


def writes_of_memory():
    for address in (*BEYOND, DESCRIPTION, CONTROL):
        yield packet(WRITE_MEMORY, struct.pack(">I", address) + b"A" * 512)


def settings():
    yield packet(WRITE_REGISTER, struct.pack(">II", CONTROL, 2))
    for address in (0x100, 0x104, 0x138, PACKET_SIZE, DESCRIPTION):
        for value in (0, 1, 0xFFFFFFFF):
            if (address, value) not in ((0x100, 1), (0x104, 1), (0x138, 1)):
                yield packet(WRITE_REGISTER, struct.pack(">II", address, value))
    yield packet(WRITE_REGISTER, struct.pack(">II", CONTROL, 0))


def cut_and_random():
    generator = random.Random(1)
    for _ in range(2000):
        command = generator.choice((2, READ_REGISTER, READ_MEMORY, WRITE_MEMORY, 0x40, 0xFFFF))
        content = generator.randbytes(generator.choice((0, 1, 4, 8, 12, 600)))
        size = generator.choice((None, 0, generator.randrange(65536)))
        yield packet(command, content, size)[: generator.choice((3, 8, 11, 1000))]
        yield generator.randbytes(generator.randrange(1000))


@pytest.mark.parametrize(
    "packets", [reads_of_memory, registers, writes_of_memory, settings, cut_and_random]
)
def test_it_goes_on(packets):
    with served() as server:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for one in packets():
                sender.sendto(one, (ADDRESS, PORT))
        with robsim.Camera(server.url) as camera:
            assert camera.read().image.shape == (240, 320, 3)
        assert server.failure is None
