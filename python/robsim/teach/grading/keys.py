"""The secret key of an assignment: unpredictable and repeatable seeds and noise."""

from __future__ import annotations

import hashlib
import hmac
import os
import secrets
import stat
import struct
import sys
import unicodedata
import warnings
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import check_int, check_text
from robsim.base.files import as_path
from robsim.base.seeds import Seed, seed_record, seed_sequence
from robsim.base.text import one_line
from robsim.teach.errors import AssignmentError

_MAGIC = "robsim-key-1 "
_BYTES = 32
_LEAST_BYTES = 16  # 128 bits
_MOST_FILE = 1024  # bytes
_PURPOSE = b"robsim grading 1"
_READABLE = stat.S_IRWXG | stat.S_IRWXO


class Key:
    """A secret that determines all randomness in graded runs, with the names of student and test.

    A seed is the HMAC-SHA256 of its purpose and the names, each preceded by its length. The world
    and the robot have separate seeds, which do not reveal each other. The key can repeat any run.

    Parameters
    ----------
    secret : bytes
        At least 128 random bits.

    Raises
    ------
    TypeError, ValueError
        If the secret is not bytes, or is too short.

    Examples
    --------
    >>> key = robsim.teach.Key(bytes(32))
    >>> key.pseudonym("ann") == key.pseudonym("ann")
    True
    """

    def __init__(self, secret: bytes) -> None:
        if not isinstance(secret, bytes):
            raise TypeError(f"secret must be bytes, got {type(secret).__name__}")
        if len(secret) < _LEAST_BYTES:
            raise ValueError(f"secret must have at least {_LEAST_BYTES} bytes, got {len(secret)}")
        self._secret = secret

    @classmethod
    def new(cls) -> Key:
        """Return a new key from the operating system's random numbers."""
        return cls(secrets.token_bytes(_BYTES))

    @classmethod
    def public(cls) -> Key:
        """Return the key of public tests, known to all."""
        return cls(hashlib.sha256(b"robsim public key").digest())

    @property
    def is_public(self) -> bool:
        """Whether this is the key of public tests."""
        return hmac.compare_digest(self._secret, Key.public()._secret)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Key:
        """Read a key from a file.

        Raises
        ------
        AssignmentError
            If the file is missing or is not a key, or if other users can read it.

        Warns
        -----
        UserWarning
            On Windows, because the readers of the file are not checked there.
        """
        file = as_path(path)
        text = _private_text(file)
        try:
            if not text.startswith(_MAGIC):
                raise ValueError
            return cls(bytes.fromhex(text.removeprefix(_MAGIC).strip()))
        except ValueError:
            raise AssignmentError(
                f"{one_line(file)} is not a key: make a key with robsim.teach.Key.new()",
                file=one_line(file),
            ) from None

    def save(self, path: str | PathLike[str]) -> None:
        """Write the key to a new file that only you can read.

        Raises
        ------
        FileExistsError
            If the file exists. With another key, the runs of its key could not be repeated.
        """
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
        descriptor = os.open(as_path(path), flags, 0o600)
        with open(descriptor, "w", encoding="ascii") as file:
            file.write(f"{_MAGIC}{self._secret.hex()}\n")

    def world_seed(self, student: str, test: str, run: int) -> int:
        """Return the 128-bit seed of the simulated world in a run.

        Parameters
        ----------
        student, test : str
            Their names; an empty student stands for all, if a test is the same for each.
        run : int
            The number of the run, from 0.
        """
        return int.from_bytes(self._digest("world", student, test, run)[:16], "little")

    def robot_seed(self, student: str, test: str, run: int) -> int:
        """Return the seed of the robot's software, which does not reveal the world's seed."""
        return int.from_bytes(self._digest("robot", student, test, run)[:16], "little")

    def noise_keys(self, student: str, test: str, run: int, frames: int) -> NDArray[np.uint64]:
        """Return the 64-bit keys for the noise of each frame of a run.

        BLAKE2b derives each key from a 256-bit secret of the run and from the number of the frame.
        No key reveals another. A longer run begins with the same keys.

        Parameters
        ----------
        student, test, run
            See `world_seed`.
        frames : int
            Number of frames.

        Returns
        -------
        array (frames,) of uint64
        """
        check_int("frames", frames, minimum=0, maximum=10_000_000)
        secret = self._digest("noise", student, test, run)
        return np.array([_frame_key(secret, index) for index in range(frames)], np.uint64)

    def frame_noise(self, student: str, test: str, run: int, index: int) -> int:
        """Return the key of a frame, numbered from 0; it is the same as in `noise_keys`."""
        check_int("index", index, minimum=0, maximum=2**63 - 1)
        return _frame_key(self._digest("noise", student, test, run), index)

    def pseudonym(self, student: str) -> str:
        """Return a student's pseudonym, which only the key can derive: ten letters and digits."""
        digest = self._digest("pseudonym", student, "", 0)
        return "".join(_LETTERS[byte % len(_LETTERS)] for byte in digest[:10])

    def _digest(self, purpose: str, student: str, test: str, run: int) -> bytes:
        check_int("run", run, minimum=0, maximum=2**63 - 1)
        parts = [purpose.encode(), _name("student", student), _name("test", test)]
        message = b"".join(struct.pack("<Q", len(part)) + part for part in (_PURPOSE, *parts))
        return hmac.digest(self._secret, message + struct.pack("<Q", run), "sha256")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Key) and hmac.compare_digest(self._secret, other._secret)

    def __hash__(self) -> int:
        return hash(self._secret)

    def __repr__(self) -> str:
        return "<Key: public>" if self.is_public else "<Key: secret>"


# Without characters that look alike; 32, so that each is equally likely.
_LETTERS = "abcdefghijkmnpqrstuvwxyz23456789"


def _frame_key(secret: bytes, index: int) -> int:
    number = struct.pack("<Q", index)
    return int.from_bytes(hashlib.blake2b(number, digest_size=8, key=secret).digest(), "little")


def _name(argument: str, name: str) -> bytes:
    return unicodedata.normalize("NFC", check_text(argument, name)).encode("utf-8", "surrogatepass")


def _private_text(file: Path) -> str:
    """Return the text of a file that no other user can read; else raise AssignmentError."""
    named = one_line(file)
    try:
        with file.open("rb") as stream:
            mode = os.fstat(stream.fileno()).st_mode
            content = stream.read(_MOST_FILE)
    except OSError as error:
        raise AssignmentError(
            f"the key {named} cannot be read: {error.strerror}", file=named
        ) from None
    if sys.platform == "win32":
        warnings.warn(f"the readers of the key {named} are not checked on Windows", stacklevel=3)
    elif mode & _READABLE:
        raise AssignmentError(
            f"other users can read the key {named} and repeat all graded runs: run chmod 600 "
            f"{named}; if students have access to this machine, make a new key",
            file=named,
        )
    return content.decode("ascii", "replace")


@dataclass(frozen=True)
class RunSeeds:
    """The random streams of a graded run."""

    world: np.random.SeedSequence  # of the scenario
    robot: np.random.SeedSequence  # of the robot half; it reveals no other seed
    #: (steps,), of the camera noise of each frame; None = from the seed of the world.
    noise_keys: NDArray[np.uint64] | None = None

    @classmethod
    def of(cls, seed: Seed) -> RunSeeds:
        """Return the seeds of the run that a simulation with this seed repeats, byte for byte."""
        world = seed_sequence(seed)
        digest = hashlib.sha256(f"robot half|{seed_record(world)}".encode()).digest()
        return cls(world, np.random.SeedSequence(int.from_bytes(digest[:16], "little")))

    @classmethod
    def of_key(cls, key: Key, student: str, test: str, run: int, steps: int) -> RunSeeds:
        """Return the seeds of a run that only the key can repeat."""
        return cls(
            np.random.SeedSequence(key.world_seed(student, test, run)),
            np.random.SeedSequence(key.robot_seed(student, test, run)),
            key.noise_keys(student, test, run, steps),
        )
