"""Misspelt names of slots."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from robsim.simulation._slots import ARGUMENTS

# What the original program called them, and what else they may be looked for under.
_OTHER_NAMES = {
    "robotModelDef": "define_model",
    "myParameterEstimatorInit": "init_parameter_estimator",
    "background": "adjust_background",
    "robotModelEval": "evaluate_model",
    "myParameterEstimator": "estimate_parameters",
    "measurePosNOrientation": "measure",
    "measurement": "measure",
    "stateEstimator": "estimate_state",
    "robotController": "control",
}


def misspelt(names: Iterable[str]) -> dict[str, str]:
    """Return the names that look like those of slots, and the slots meant."""
    names = list(names)
    known = {_plain(name): slot for name, slot in _OTHER_NAMES.items()}
    known |= {_plain(slot): slot for slot in ARGUMENTS}
    meant = {}
    for name in names:
        close = difflib.get_close_matches(_plain(name), known, 1, cutoff=0.8)
        slot = known[close[0]] if close else name
        # control_old.py beside control.py is a copy that somebody keeps.
        is_copy = slot in names and re.match(rf"{slot}[\W\d_]", name.lower())
        if slot != name and not is_copy:
            meant[name] = slot
    return meant


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())
