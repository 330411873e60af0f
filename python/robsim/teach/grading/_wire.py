"""Messages between the grader and a worker: heads, lengths, deadlines; no code, no pickle back.

A message is a head of 8 bytes, ``<HHI``: kind, 0, length of the body; and the body, which for steps
and answers is the fixed struct of ``cpp/robsim/simulation/remote/step_message.cpp``.
"""

from __future__ import annotations

import math
import socket
import struct
import sys
import time
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from robsim import _core
from robsim._core import RobotModel

_HEAD = struct.Struct("<HHI")
_BUFFER = 1 << 16


class Kind(IntEnum):
    """The type of a message."""

    HELLO = 1  # to the worker: the submission, and the inputs of the robot half
    READY = 2  # to the grader: `Ready`
    STEP = 3  # to the worker: a step as far as known
    ANSWER = 4  # to the grader: the same, filled in
    END = 5  # to the worker: no more steps
    ERROR = 6  # to the grader: an `ErrorText`, in JSON
    CALL = 7  # to the worker: the number of a function, and arrays
    RESULT = 8  # to the grader: arrays


#: Most bytes of a body that comes from a worker.
LIMITS = {Kind.READY: 1 << 10, Kind.ANSWER: 1 << 14, Kind.ERROR: 1 << 14}


class WireError(Exception):
    """An unexpected or malformed message."""


class Channel:
    """One end of the connection. The two sides alternate, with one message at a time.

    The limits have the most bytes of each kind, and other kinds are refused. Without limits the
    other side is trusted.
    """

    def __init__(self, connection: socket.socket, limits: dict[Kind, int] | None = None) -> None:
        self._socket = connection
        self._limits = limits
        self._patience: float | None = None
        connection.settimeout(None)
        self._native: _core.MessageSocket | None = None
        if sys.platform != "win32":
            self._native = _core.MessageSocket(connection.fileno(), limits)
        elif connection.family == socket.AF_INET:  # whose last bytes would wait for an answer
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, kind: Kind, *parts: bytes | memoryview, patience: float | None = None) -> None:
        """Send a message.

        Raise TimeoutError after the patience (s), OSError if the connection fails.
        """
        self._wait_at_most(patience)
        body = b"".join(parts)
        self._socket.sendall(_HEAD.pack(kind, 0, len(body)) + body)

    def receive(self, patience: float | None = None) -> tuple[Kind, bytes]:
        """Return the next message.

        Raise TimeoutError after the patience (s), OSError or EOFError for a closed connection, and
        WireError for a wrong kind, a wrong length or two messages.
        """
        deadline = None if patience is None else time.monotonic() + patience
        self._wait_at_most(patience)
        have = bytearray()
        while len(have) < _HEAD.size:
            self._read(have, deadline)
        kind, length = self._head(have)
        while len(have) < _HEAD.size + length:
            self._read(have, deadline)
        if len(have) > _HEAD.size + length:
            raise WireError("more than one message at a time")
        return kind, bytes(memoryview(have)[_HEAD.size :])

    def exchange(
        self, kind: Kind, *parts: bytes | memoryview, patience: float | None = None
    ) -> tuple[Kind, bytes]:
        """Send a message and receive the next, in a third of the time; patience (s) is for each."""
        if self._native is None:
            self.send(kind, *parts, patience=patience)
            return self.receive(patience)
        seconds = math.inf if patience is None else patience
        try:
            number, answer = self._native.exchange(kind, parts, seconds)
            return Kind(number), answer
        except ValueError as error:
            raise WireError(str(error)) from None

    def _wait_at_most(self, patience: float | None) -> None:
        if patience != self._patience:  # each change is a system call
            self._socket.settimeout(patience)
            self._patience = patience

    def _head(self, message: bytearray) -> tuple[Kind, int]:
        number, zero, length = _HEAD.unpack_from(message)
        try:
            kind = Kind(number)
        except ValueError:
            kind = None
        if kind is None or zero or (self._limits is not None and kind not in self._limits):
            raise WireError("an unknown message type")
        if self._limits is not None and length > self._limits[kind]:
            raise WireError(
                f"a message of {length} bytes exceeds the limit of {self._limits[kind]}"
            )
        return kind, length

    def _read(self, have: bytearray, deadline: float | None) -> None:
        """Append more of a message to the received part."""
        if have and deadline is not None:
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError("no whole message in time")
            self._wait_at_most(left)
        if not (more := self._socket.recv(_BUFFER)):
            where = " in the middle of a message" if have else ""
            raise EOFError(f"the other side has closed the connection{where}")
        have += more

    def close(self) -> None:
        self._native = None
        self._socket.close()


@dataclass(frozen=True)
class Ready:
    """The message of a worker that has loaded a submission."""

    filled: tuple[str, ...]  # the slots filled with code
    switched_on: tuple[str, ...]  # the slots set to the default stage
    #: Whether its parameter estimator knows the standard errors of its estimates.
    has_standard_errors: bool
    model: RobotModel  # of the robot half

    _STRUCT = struct.Struct("<III16d")

    def to_bytes(self, slots: tuple[str, ...]) -> bytes:
        theta = self.model.theta.ravel().tolist()
        masks = (_mask(self.filled, slots), _mask(self.switched_on, slots))
        return self._STRUCT.pack(*masks, self.has_standard_errors, self.model.dt, *theta)

    @classmethod
    def from_bytes(cls, body: bytes, slots: tuple[str, ...]) -> Ready:
        """Return the content of a body; raise WireError, or ValueError for an invalid model."""
        if len(body) != cls._STRUCT.size:
            raise WireError("a message of the wrong length")
        filled, switched_on, errors, dt, *theta = cls._STRUCT.unpack(body)
        if max(filled, switched_on) >= 1 << len(slots) or errors > 1:
            raise WireError("a message with unknown slots")
        if not (np.isfinite(dt) and dt > 0):
            raise ValueError("the model must have a dt above 0 s")
        model = RobotModel.from_theta(np.reshape(theta, (3, 5)), dt=dt)
        return cls(_names(filled, slots), _names(switched_on, slots), bool(errors), model)


def _mask(names: tuple[str, ...], slots: tuple[str, ...]) -> int:
    return sum(1 << slots.index(name) for name in names)


def _names(mask: int, slots: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(slot for bit, slot in enumerate(slots) if mask >> bit & 1)
