"""What an assignment may allow a submission, so that it cannot know what it must not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from robsim.simulation import Scenario
from robsim.simulation.slots import ESTIMATORS, ROBOT, STEP, WORLD, names
from robsim.teach.isolation import Limits
from robsim.teach.submissions import Rules

#: The slots of the world half.
WORLD_SLOTS = names(half=WORLD)

#: What a submission may see of the frames: all, the blobs in them alone, nothing; None = all if it
#: fills `measure`, else nothing.
Frames = bool | Literal["blobs"] | None


def given_to(slots: Iterable[str], frames: Frames) -> str:
    """Return what a submission that fills some slots sees: "frames", "blobs" or "pose"."""
    if frames == "blobs":
        return "blobs"
    return "frames" if ("measure" in slots if frames is None else frames) else "pose"


def rules_of(
    slots: str | Iterable[str],
    functions: str | Iterable[str],
    imports: Iterable[str] | None,
    masked: Iterable[str],
    limits: Limits,
) -> Rules:
    """Return the rules of an assignment; raise TypeError or ValueError."""
    rules = Rules.of(
        slots=slots,
        functions=functions,
        imports=imports,
        masked=masked,
        files=limits.submission_files,
        size=limits.submission_size,
        file_size=limits.submission_file_size,
    )
    of_world = [slot for slot in rules.slots if slot in WORLD_SLOTS]
    if of_world and len(of_world) < len(rules.slots):
        other = next(slot for slot in rules.slots if slot not in of_world)
        raise ValueError(
            f"slots must be of the robot half, or of the world, got {other} and {of_world[0]}: "
            "what fills the world knows the truth"
        )
    return rules


def check_samples(slots: Sequence[str], scenario: Scenario) -> None:
    """Raise ValueError where what has samples of the truth may act on them."""
    stages = {*names(half=ROBOT, when=STEP)} - ESTIMATORS
    others = [slot for slot in slots if slot in stages]
    estimators = [slot for slot in slots if slot in ESTIMATORS]
    if estimators and others and scenario.identify_from == "truth":
        raise ValueError(
            f"slots has {estimators[0]} and {others[0]}, and identify_from is 'truth': the samples "
            f"tell where the robot is, which {others[0]} must not know; take "
            "Scenario(identify_from='measurement'), or grade them apart"
        )
