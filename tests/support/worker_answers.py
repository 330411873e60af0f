"""Answers of a worker as its test writes them, and a run that hears them."""

import struct

import robsim
from robsim import _core

# Where in a message its numbers lie: see step_message.cpp.
K, U = 0, 8 + 8
DONE, PARTS, MISSED, N_BLOBS, N_STATES, NEXT = (32 + 4 * i for i in range(6))
FRAME = 56
PARAMETERS = FRAME + 96 + 8 + 15 * 8 + 3 * 8
ERRORS = PARAMETERS + 15 * 8
MEASURED = ERRORS + 15 * 8
ESTIMATE = MEASURED + 14 * 8
INPUT = ESTIMATE + 12 * 8
SIZE = INPUT + 16
HAS = {"frame": 2, "parameters": 8, "errors": 16, "measured": 32, "covariance": 64, "missed": 128}
HAS |= {"estimate": 256, "u": 512}
STAGES = ("estimate_parameters", "measure", "estimate_state", "control")


class Refused(Exception):
    pass


def refuse(slot, k, what):
    raise Refused(slot, k, what)


def answer(message, *parts, numbers=(), end=b"", words=()):
    """The answer of somebody who says these things, from the message that came."""
    said = bytearray(message[:SIZE])
    said[FRAME:] = bytes(SIZE - FRAME)
    struct.pack_into("<6I", said, DONE, 15, sum(HAS[part] for part in parts), 0, 0, 0, 0)
    for place, value in numbers:
        struct.pack_into("<d", said, place, value)
    for place, value in words:
        struct.pack_into("<I", said, place, value)
    return bytes(said) + end


def run(reply, steps=2, slots=STAGES):
    """A run whose stages somebody fills who gives `reply(message)` to each message."""
    sim = robsim.Simulation(resolution=(200, 200), seed=1)
    robot = _core.RemoteRobot(
        lambda message, pixels, slot, k: reply(message),
        refuse,
        world=sim._world,
        slots=slots,
        sends_frames=False,
        sends_samples=True,
        measures_first=False,
        has_standard_errors=False,
        largest_input=12.0,
    )
    for slot in slots:
        sim._core.set_slot(slot, robot)
        sim._callbacks[slot] = robot
    return sim.run(steps)


def good(message):
    return answer(message, "u", "estimate", "measured", "parameters", numbers=[(INPUT, 0.5)])


def stored(answers):
    """Return a sequence of answers as the corpus has it, each after its length."""
    return b"".join(struct.pack("<I", len(answer)) + answer for answer in answers)


def replies(content):
    """Return a function that gives the answers of such a file, at the end the last one again.

    A step of 0 stands for the step of the message.
    """
    answers = []
    while len(content) >= 4:
        (length,) = struct.unpack_from("<I", content)
        answers.append(content[4 : 4 + length])
        content = content[4 + length :]
    rest = iter(answers)
    last = b""

    def reply(message):
        nonlocal last
        last = next(rest, last)
        return last if last[:8].strip(b"\0") else message[:DONE] + last[DONE:]

    return reply
