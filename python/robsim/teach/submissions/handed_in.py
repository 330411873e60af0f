"""The callbacks of a submission alone, without stages, objects and templates of robsim."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from robsim.base.text import listed
from robsim.simulation.slots import SLOTS


def own_slots(callbacks: Mapping[str, Any], asked: Iterable[str]) -> dict[str, Any]:
    """Return the callbacks without those that robsim has made.

    Raise ValueError, which says why, if nothing is left, or nothing but untouched templates.
    """
    asked = [name for name in asked if name in callbacks]
    why = {name: reason for name in asked if (reason := _reason(name, callbacks[name]))}
    left = {name: callback for name, callback in callbacks.items() if name not in why}
    untouched = [name for name in left if _is_template(name, left[name])]
    if asked and len(untouched) == len(left):
        why |= dict.fromkeys(untouched, "is the template, untouched")
        raise ValueError(f"nothing is handed in: {listed(f'{n} {r}' for n, r in why.items())}")
    return left


def _reason(slot: str, callback: Any) -> str:
    if slot not in SLOTS:
        return ""
    if callback is False:
        return "is switched off (ENABLED = False)"
    if callback is True:
        return "is the stage of robsim"
    kind = callback if isinstance(callback, FunctionType) else type(callback)
    is_ours = f"{kind.__module__}.".startswith("robsim.")
    return "is an object of robsim" if is_ours else ""


def _is_template(slot: str, callback: Any) -> bool:
    call = callback if isinstance(callback, FunctionType) else vars(type(callback)).get("__call__")
    return _told(getattr(call, "__code__", None)) in _TEMPLATES.get(slot, ())


def _told(code: Any) -> Any:
    if not isinstance(code, CodeType):
        return None
    constants = tuple(repr(one) for one in code.co_consts[1:] if not isinstance(one, CodeType))
    return code.co_code, code.co_names, code.co_varnames, constants


def _templates(slot: str) -> frozenset[Any]:
    """Return the functions of all templates of a slot, and the calls of their classes."""
    found = set()
    for folder in (_HERE.parent / "simulation/templates", _HERE / "tasks/start"):
        for file in folder.rglob(f"{slot}.py"):
            waiting: list[Any] = [compile(file.read_bytes(), slot, "exec")]
            for code in waiting:
                waiting += [one for one in code.co_consts if isinstance(one, CodeType)]
            found |= {_told(one) for one in waiting if one.co_name in (slot, "__call__")}
    return frozenset(found)


_HERE = Path(__file__).parents[1]
#: Read before a worker is shut in.
_TEMPLATES = {slot: _templates(slot) for slot in SLOTS}
