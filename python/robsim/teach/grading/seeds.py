"""The seeds of a graded run: world and robot half apart."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim.base.seeds import Seed, seed_record, seed_sequence
from robsim.teach.grading.keys import Key


@dataclass(frozen=True)
class RunSeeds:
    """What is random in a graded run.

    Attributes
    ----------
    world : SeedSequence
        Of the scenario.
    robot : SeedSequence
        Of the robot half, from which nobody finds that of the world.
    noise_keys : array (steps,) of uint64, or None
        Of the camera noise of each frame; None = from the seed of the world.
    """

    world: np.random.SeedSequence
    robot: np.random.SeedSequence
    noise_keys: NDArray[np.uint64] | None = None

    @classmethod
    def of(cls, seed: Seed) -> RunSeeds:
        """Return those of a run that a simulation with this seed gives again, byte for byte."""
        world = seed_sequence(seed)
        digest = hashlib.sha256(f"robot half|{seed_record(world)}".encode()).digest()
        return cls(world, np.random.SeedSequence(int.from_bytes(digest[:16], "little")))

    @classmethod
    def of_key(cls, key: Key, student: str, test: str, run: int, steps: int) -> RunSeeds:
        """Return those of a run that only who has the key can repeat."""
        return cls(
            np.random.SeedSequence(key.world_seed(student, test, run)),
            np.random.SeedSequence(key.robot_seed(student, test, run)),
            key.noise_keys(student, test, run, steps),
        )
