"""Random seeds: one per run, split into independent named streams for `Simulation`."""

from __future__ import annotations

from typing import Any

import numpy as np

Seed = int | np.random.SeedSequence | np.random.Generator | None

#: The streams of a run, in the order of their spawn keys.
STREAMS = ("controller", "noise", "start", "user", "dropout")


def seed_sequence(seed: Seed) -> np.random.SeedSequence:
    """Return the seed of a run.

    Parameters
    ----------
    seed : int, SeedSequence, Generator or None
        A Generator is asked for a new seed; None = entropy of the operating system.

    Raises
    ------
    TypeError, ValueError
        If `seed` has another type, or is negative.
    """
    if isinstance(seed, np.random.SeedSequence):
        return seed
    if isinstance(seed, np.random.Generator):
        return np.random.SeedSequence(int(seed.integers(2**63)))
    if seed is None:
        return np.random.SeedSequence()
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)):
        raise TypeError(f"seed must be an int, SeedSequence, Generator or None, got {seed!r}")
    if seed < 0:
        raise ValueError(f"seed must be at least 0, got {seed}")
    return np.random.SeedSequence(int(seed))


def stream(seed: np.random.SeedSequence, name: str) -> np.random.SeedSequence:
    """Return the seed of a named stream, always the same for the same `seed` and `name`."""
    key = (*seed.spawn_key, STREAMS.index(name))
    return np.random.SeedSequence(seed.entropy, spawn_key=key)


def stream_number(seed: np.random.SeedSequence, name: str) -> int:
    """Return a named stream as the 64-bit number that seeds the C++ core."""
    return int(stream(seed, name).generate_state(1, np.uint64)[0])


def seed_record(seed: np.random.SeedSequence) -> dict[str, Any]:
    """Return the seed as a trace stores it; ``SeedSequence(**record)`` restores it."""
    entropy = seed.entropy
    if isinstance(entropy, (int, np.integer)):
        return {"entropy": int(entropy), "spawn_key": list(map(int, seed.spawn_key))}
    words = [] if entropy is None else [int(word) for word in entropy]
    return {"entropy": words, "spawn_key": list(map(int, seed.spawn_key))}
