"""Suggestions for misspelled slot names, for the warnings and errors of `CallbackFolder`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from robsim.simulation._slots import ARGUMENTS

# Names of the slots in the program of 2008, and other likely names.
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


def misspelled(names: Iterable[str]) -> dict[str, str]:
    """Return the names that resemble a slot name, and that slot."""
    names = list(names)
    known = {_plain(name): slot for name, slot in _OTHER_NAMES.items()}
    known |= {_plain(slot): slot for slot in ARGUMENTS}
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
