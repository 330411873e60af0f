"""One seed per run, independent named streams."""

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
        From a Generator a new seed is drawn; None = unpredictable.

    Raises
    ------
    TypeError, ValueError
        For anything else, and for negative numbers.
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
    """Return the seed of a named stream; asking twice gives the same."""
    key = (*seed.spawn_key, STREAMS.index(name))
    return np.random.SeedSequence(seed.entropy, spawn_key=key)


def stream_number(seed: np.random.SeedSequence, name: str) -> int:
    """Return a named stream as the number that seeds the core."""
    return int(stream(seed, name).generate_state(1, np.uint64)[0])


def seed_record(seed: np.random.SeedSequence) -> dict[str, Any]:
    """Return what a trace stores of the seed: ``SeedSequence(**record)`` gives it back."""
    entropy = seed.entropy
    if isinstance(entropy, (int, np.integer)):
        return {"entropy": int(entropy), "spawn_key": list(map(int, seed.spawn_key))}
    words = [] if entropy is None else [int(word) for word in entropy]
    return {"entropy": words, "spawn_key": list(map(int, seed.spawn_key))}
