"""The callbacks of a submission, without stages, objects and templates of robsim."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import FunctionType
from typing import Any

from robsim.base.text import listed
from robsim.simulation.slots import SLOTS


def own_slots(
    callbacks: Mapping[str, Any],
    asked: Iterable[str],
    masked: Mapping[int, str],
    statements_of: Callable[[str], Iterable[ast.stmt]],
) -> dict[str, Any]:
    """Return the callbacks except those made by robsim.

    `masked` has the masks by the ids of their objects; `statements_of` returns the top-level
    statements of a callback's module.
    Raise ValueError with the reason if nothing is left, or only untouched templates.
    """
    asked = [name for name in asked if name in callbacks]
    why = {name: reason for name in asked if (reason := _reason(name, callbacks[name], masked))}
    left = {name: callback for name, callback in callbacks.items() if name not in why}
    untouched = [name for name in left if _are_of_templates(statements_of(name))]
    if asked and len(untouched) == len(left):
        why |= dict.fromkeys(untouched, "is the template, untouched")
        raise ValueError(f"nothing is handed in: {listed(f'{n} {r}' for n, r in why.items())}")
    if "robsim.RecursiveLeastSquares" in masked.values() and _STAGE in left and _MAKER not in left:
        raise ValueError(
            f"{_MAKER} {why.get(_MAKER, 'is missing')}: {_STAGE} would use robsim's own estimator"
        )
    return left


def _reason(slot: str, callback: Any, masked: Mapping[int, str]) -> str:
    if slot not in SLOTS:
        return ""
    if callback is False:
        return "is switched off (ENABLED = False)"
    if callback is True:
        return "is the stage of robsim"
    kind = callback if isinstance(callback, FunctionType) else type(callback)
    is_ours = f"{kind.__module__}.".startswith("robsim.")
    if is_ours:
        return "is an object of robsim"
    bases = [masked[id(base)] for base in type(callback).__mro__ if id(base) in masked]
    return f"is a {bases[0]} by another name" if bases else ""


def _are_of_templates(statements: Iterable[ast.stmt]) -> bool:
    try:
        return all(_is_switch(one) or _text(one) in _TEMPLATES for one in statements)
    except RecursionError:  # of an expression that no template has
        return False


def _is_switch(statement: ast.stmt) -> bool:
    """Whether a template may have another value here: ``ENABLED = True``."""
    return isinstance(statement, ast.Assign) and isinstance(
        getattr(statement.value, "value", None), bool
    )


def _text(statement: ast.stmt) -> str:
    """Return the text of a statement without docstrings, which it loses."""
    for one in ast.walk(statement):
        if isinstance(body := getattr(one, "body", None), list):
            body[:] = [each for each in body if not _is_docstring(each)]
    return "" if _is_docstring(statement) else ast.dump(statement)


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _templates() -> frozenset[str]:
    """Return the text of each statement in templates of slots."""
    return frozenset(
        _text(statement)
        for folder in (_HERE.parent / "simulation/templates", _HERE / "tasks/start")
        for file in folder.rglob("*.py")
        for statement in ast.parse(file.read_bytes()).body
    )


_MAKER, _STAGE = "init_parameter_estimator", "estimate_parameters"
_HERE = Path(__file__).parents[1]
#: Read before the worker's sandbox is closed.
_TEMPLATES = _templates()
