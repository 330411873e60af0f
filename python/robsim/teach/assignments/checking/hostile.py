"""Submissions that try to get points otherwise, or to end the grading; for any slots."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from robsim.simulation.slots import SLOTS, STEP

_FILES = Path(__file__).parents[1] / "templates/hostile"

#: What stands for doing nothing, of slots that are asked at each step.
_NOTHING = {"control": "(0.0, 0.0)"}


def hostile_submissions(slots: tuple[str, ...]) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the name of each, and its files: the text by name."""
    at_each_step = [slot for slot in slots if SLOTS[slot].when == STEP] or slots
    for file in sorted(_FILES.glob("*.py")):
        text = file.read_text(encoding="utf-8")
        yield file.stem, {f"{slot}.py": _for_slot(text, slot) for slot in at_each_step}


def _for_slot(text: str, slot: str) -> str:
    return text.replace("SLOT", slot).replace("NOTHING", _NOTHING.get(slot, "None"))
