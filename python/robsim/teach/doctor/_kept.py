"""The numbers that an estimator keeps or reads: attributes, variables of closures, globals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from robsim.base.checks import Floats

_DEPTH = 3  # of objects within the estimator
_FEW = 10  # matrices, not samples


def arrays_in(value: Any, depth: int = _DEPTH, *, shared: bool = False) -> Iterator[Floats]:
    """Yield arrays in attributes, variables of a closure, and lists and dicts of these.

    ``shared``: also single numbers, class attributes, and globals that its functions read.
    """
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and value.size:
            yield value
        return
    if shared and isinstance(value, float):
        yield np.array(value)
    if depth == 0 or isinstance(value, (str, bytes, type)):
        return
    if isinstance(value, (list, tuple)) and len(value) < _FEW and (of_lists := _matrix(value)):
        yield from of_lists
        return
    inner = [*attributes_of(value).values(), *_variables(value)]
    if isinstance(value, (list, tuple, dict)) and len(value) < _FEW:
        inner += value.values() if isinstance(value, dict) else value
    if shared:
        inner += _shared_by(value)
    for one in inner:
        yield from arrays_in(one, depth - 1, shared=shared)


def attributes_of(value: Any) -> dict[str, Any]:
    slots = [name for cls in type(value).__mro__ for name in getattr(cls, "__slots__", ())]
    kept = {name: getattr(value, name) for name in slots if hasattr(value, name)}
    return kept | getattr(value, "__dict__", {})


def _variables(function: Any) -> Iterator[Any]:
    for cell in getattr(function, "__closure__", None) or ():
        with suppress(ValueError):  # it is empty
            yield cell.cell_contents


def _shared_by(value: Any) -> Iterator[Any]:
    """Yield the numbers of the value's class, and the module variables that its functions read."""
    of_class = {name: one for cls in type(value).__mro__[::-1] for name, one in vars(cls).items()}
    yield from (one for one in of_class.values() if isinstance(one, (np.ndarray, list, float)))
    for one in (value, *of_class.values()):
        function = getattr(one, "fget", one)  # of a property
        code, known = getattr(function, "__code__", None), getattr(function, "__globals__", {})
        for name in getattr(code, "co_names", ()):
            if isinstance(known.get(name), (np.ndarray, list, dict, float)):
                yield known[name]


def _matrix(rows: Sequence[Any]) -> list[Floats]:
    """Return nested lists of numbers as an array; empty = other contents."""
    if not rows or not all(isinstance(row, (list, tuple)) for row in rows):
        return []
    try:
        return [np.array(rows, dtype=float)]
    except (TypeError, ValueError):
        return []
