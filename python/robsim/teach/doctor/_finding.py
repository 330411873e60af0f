"""What is wrong first with callbacks that come from anywhere, in a sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robsim.simulation.slots import ROBOT, names
from robsim.teach.doctor.callbacks.folder import check_slot
from robsim.teach.doctor.callbacks.scenes import Setting
from robsim.teach.submissions.imports import not_here


def first_finding(make: Callable[[], Mapping[str, Any]], slots: Iterable[str]) -> str:
    """Return the first problem of fresh callbacks from `make`, and its place; "" = no problem."""
    for slot in slots:
        if slot in names(half=ROBOT) and callable(make().get(slot)):
            first = next(iter(check_slot(slot, make, Setting.usual()).problems), None)
            if first is not None and str(not_here("")) not in first.sentence:  # which its runs tell
                places = [text for text in (first.where, first.code) if text]
                return "\n".join([f"{slot}: {first.sentence}", *places])
    return ""
