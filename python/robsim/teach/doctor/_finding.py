"""The first problem of callbacks from any source, in a sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robsim.simulation.slots import ROBOT, names
from robsim.teach.doctor._errors import NOT_HERE
from robsim.teach.doctor.callbacks.folder import Surroundings, check_slot


def first_finding(
    make: Callable[[], Mapping[str, Any]], slots: Iterable[str], masked: tuple[str, ...]
) -> str:
    """Return the first problem of fresh callbacks from `make`, and its place; "" = no problem.

    No advice has a masked name.
    """
    around = Surroundings(masked=masked)
    for slot in slots:
        if slot in names(half=ROBOT) and callable(make().get(slot)):
            problems = check_slot(slot, make, around.setting).problems
            first = next(iter(around.with_allowed(problems)), None)
            if first is not None and first.kind != NOT_HERE:  # reported by its runs
                places = [text for text in (first.where, first.code) if text]
                return "\n".join([f"{slot}: {first.sentence}", *places])
    return ""
