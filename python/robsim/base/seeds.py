"""Random seeds: one per run, split into independent named streams for `Simulation`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim.base.text import quoted


@dataclass(frozen=True, repr=False)
class SeedRecord:
    """A seed other than a plain int, as a value: the content of a `numpy.random.SeedSequence`."""

    entropy: int | tuple[int, ...]
    spawn_key: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        _check("entropy", self.entropy if isinstance(self.entropy, tuple) else (self.entropy,))
        _check("spawn_key", self.spawn_key)

    def __repr__(self) -> str:
        return f"SeedSequence(entropy={self.entropy}, spawn_key={self.spawn_key})"


_MOST_BITS = 4096  # at most 1234 digits: Python writes 4300


def _check(name: str, numbers: Any) -> None:
    for n in numbers if isinstance(numbers, tuple) else (None,):
        if type(n) is not int or n < 0 or n.bit_length() > _MOST_BITS:
            raise ValueError(f"{name} must lie within 0..2**{_MOST_BITS} - 1, got {quoted(n)}")


Seed = int | np.random.SeedSequence | np.random.Generator | SeedRecord | None

#: The streams of a run, in the order of their spawn keys.
STREAMS = (
    *("controller", "noise", "start", "user", "dropout", "disturbance", "mismatch"),
    "faults",
)
_ROBOTS = 2**16  # the spawn key under which robots 1, 2, ... have theirs: of no stream


def seed_sequence(seed: Seed) -> np.random.SeedSequence:
    """Return the seed of a run; a Generator draws one, and None = entropy of the operating system.

    A negative or huge number, or another type, raises ValueError or TypeError.
    """
    if isinstance(seed, np.random.SeedSequence):
        return seed
    if isinstance(seed, SeedRecord):
        return np.random.SeedSequence(seed.entropy, spawn_key=seed.spawn_key)
    if isinstance(seed, np.random.Generator):
        return np.random.SeedSequence(int(seed.integers(2**63)))
    if seed is None:
        return np.random.SeedSequence()
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)):
        raise TypeError(f"seed must be an int, SeedSequence, Generator or None, got {quoted(seed)}")
    _check("seed", (int(seed),))
    return np.random.SeedSequence(int(seed))


def seed_value(seed: Seed) -> int | SeedRecord | None:
    """Return a seed as data: an int if sufficient, or a record; None stays None."""
    if type(seed) is int:
        _check("seed", (seed,))
    if seed is None or type(seed) is int:
        return seed
    if not isinstance(seed, SeedRecord):
        record = seed_record(seed_sequence(seed))
        entropy = record["entropy"]
        is_int = isinstance(entropy, int)
        seed = SeedRecord(entropy if is_int else tuple(entropy), tuple(record["spawn_key"]))
    if isinstance(seed.entropy, int) and not seed.spawn_key:
        return seed.entropy
    return seed


def stream(seed: np.random.SeedSequence, name: str, robot: int = 0) -> np.random.SeedSequence:
    """Return the seed of a named stream, always the same for the same arguments.

    It does not depend on the number of robots. The world's "noise" and "faults" are of robot 0.
    """
    own = (_ROBOTS, robot) if robot else ()
    key = (*seed.spawn_key, *own, STREAMS.index(name))
    return np.random.SeedSequence(seed.entropy, spawn_key=key)


def stream_number(seed: np.random.SeedSequence, name: str, robot: int = 0) -> int:
    """Return a named stream as the 64-bit number that seeds the C++ core."""
    return int(stream(seed, name, robot).generate_state(1, np.uint64)[0])


def random_bits(seed: int | np.random.SeedSequence) -> Iterator[int]:
    """Yield numbers of 64 random bits; ``(bits >> 11) * 2.0**-53`` is uniform in [0, 1).

    All numpy versions give the same bits for a seed; a Generator's methods may change (NEP 19).
    """
    source = np.random.PCG64(seed)
    while True:
        yield source.random_raw()


def seed_record(seed: np.random.SeedSequence) -> dict[str, Any]:
    """Return the seed as a trace stores it; ``SeedSequence(**record)`` restores it."""
    entropy = seed.entropy
    if isinstance(entropy, (int, np.integer)):
        return {"entropy": int(entropy), "spawn_key": list(map(int, seed.spawn_key))}
    words = [] if entropy is None else [int(word) for word in entropy]
    return {"entropy": words, "spawn_key": list(map(int, seed.spawn_key))}
