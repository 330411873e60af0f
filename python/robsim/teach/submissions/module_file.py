"""The slots and functions that a single Python file defines, told without running it."""

from __future__ import annotations

import symtable

from robsim.base.text import one_line
from robsim.simulation.folders.callback_folder import misspelled
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.python_text import quiet


def slots_of_module(text: str, file: str, slots: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of some slots and functions that a file defines at its top level.

    Raises
    ------
    SubmissionError
        If there is none, with what may be meant.
    """
    with quiet():
        table = symtable.symtable(text, file, "exec")
    defined = {s.get_name() for s in table.get_symbols() if s.is_assigned() or s.is_imported()}
    found = tuple(slot for slot in slots if slot in defined)
    if not found:
        raise no_slot(one_line(file), defined, slots)
    return found


def _call_of(name: str) -> str:
    return f"{name}({SLOTS[name].argument if name in SLOTS else '...'})"


def no_slot(place: str, defined: set[str], slots: tuple[str, ...]) -> SubmissionError:
    """Return the error for a file or notebook that has nothing of what it may."""
    wanted = " or ".join(map(_call_of, slots))
    hints = [
        f"; is {one_line(name)} meant to be {slot}?"
        for name, slot in sorted(misspelled(defined).items())
        if slot in slots
    ]
    first = next(iter(slots))
    lacks = "fills no slot" if first in SLOTS else "defines no function that is asked for"
    return SubmissionError(
        f"{place} {lacks}: define {wanted}, or write {first} = ... for an object that can be "
        "called" + "".join(hints[:3]),
        file=place,
    )
