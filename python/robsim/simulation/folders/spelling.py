"""Suggestions for misspelled slot names, for the warnings and errors of `CallbackFolder`."""

from __future__ import annotations

import re
from collections.abc import Iterable

from robsim.base.spelling import closest
from robsim.simulation.slots import SLOTS

_CUTOFF = 0.8  # a folder has files of the user's own, too


def misspelled(names: Iterable[str]) -> dict[str, str]:
    """Return the names that resemble a slot name, and that slot."""
    names = list(names)
    slots = {other: name for name, slot in SLOTS.items() for other in (*slot.other_names, name)}
    suggestions = {}
    for name in names:
        slot = slots.get(closest(name, slots, cutoff=_CUTOFF) or "", name)
        # control_old.py beside control.py is a backup copy.
        is_copy = slot in names and re.match(rf"{slot}[\W\d_]", name.lower())
        if slot != name and not is_copy:
            suggestions[name] = slot
    return suggestions
