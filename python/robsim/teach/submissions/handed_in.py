"""The callbacks of a submission alone, without stages, objects and templates of robsim."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from robsim.base.text import listed
from robsim.simulation.slots import SLOTS


def own_slots(
    callbacks: Mapping[str, Any], asked: Iterable[str], masked: Iterable[str]
) -> dict[str, Any]:
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
    if "robsim.RecursiveLeastSquares" in masked and _STAGE in left and _MAKER not in left:
        raise ValueError(
            f"{_MAKER} {why.get(_MAKER, 'is missing')}: {_STAGE} would have the estimator of robsim"
        )
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
    """Whether a template has exactly the functions and methods of its module."""
    call = callback if isinstance(callback, FunctionType) else vars(type(callback)).get("__call__")
    there = getattr(call, "__globals__", {})
    own = [one for one in there.values() if getattr(one, "__module__", "") == there["__name__"]]
    own += [one for kind in own if isinstance(kind, type) for one in vars(kind).values()]
    codes = [one.__code__ for one in own if isinstance(one, FunctionType)]
    return bool(codes) and _functions(codes) in _TEMPLATES.get(slot, ())


def _functions(codes: Iterable[CodeType]) -> frozenset[Any]:
    """Return the code of functions with all inner functions."""
    waiting = [*codes]
    for code in waiting:
        waiting += [one for one in code.co_consts if isinstance(one, CodeType)]
    return frozenset(_told(one) for one in waiting if one.co_flags & CO_OPTIMIZED)


def _told(code: Any) -> Any:
    if not isinstance(code, CodeType):
        return None
    has_text = isinstance(next(iter(code.co_consts), 0), (str, type(None)))  # or None in its place
    values = code.co_consts[has_text:]
    constants = tuple(repr(one) for one in values if not isinstance(one, CodeType))
    return code.co_code, code.co_names, code.co_varnames, constants


def _templates(slot: str) -> frozenset[Any]:
    """Return the functions of each template of a slot."""
    return frozenset(
        _functions([compile(file.read_bytes(), slot, "exec")])
        for folder in (_HERE.parent / "simulation/templates", _HERE / "tasks/start")
        for file in folder.rglob(f"{slot}.py")
    )


_MAKER, _STAGE = "init_parameter_estimator", "estimate_parameters"
_HERE = Path(__file__).parents[1]
#: Read before a worker is shut in.
_TEMPLATES = {slot: _templates(slot) for slot in SLOTS}
