"""Suggestions for misspelled slot names, for the warnings and errors of `CallbackFolder`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from robsim.simulation._slots import SLOTS


def misspelled(names: Iterable[str]) -> dict[str, str]:
    """Return the names that resemble a slot name, and that slot."""
    names = list(names)
    known = {_plain(other): name for name, slot in SLOTS.items() for other in slot.other_names}
    known |= {_plain(slot): slot for slot in SLOTS}
    suggestions = {}
    for name in names:
        close = difflib.get_close_matches(_plain(name), known, 1, cutoff=0.8)
        slot = known[close[0]] if close else name
        # control_old.py beside control.py is a backup copy.
        is_copy = slot in names and re.match(rf"{slot}[\W\d_]", name.lower())
        if slot != name and not is_copy:
            suggestions[name] = slot
    return suggestions


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())
