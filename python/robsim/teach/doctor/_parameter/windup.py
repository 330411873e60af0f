"""Windup: what a long rest does to an estimator's P and to its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.base.source_line import SourceLine
from robsim.teach.doctor._lines import line_that_sets
from robsim.teach.doctor._trial import EstimatorUnderTest

# P grows by 1 / lambda at each sample that brings nothing new. Beyond 1e15 times its size a double
# has no digit left of what was known.
MAXIMUM_GROWTH = 1e15
_DEPTH = 3  # of objects within the estimator
_FEW = 10  # matrices, not samples


def largest_square(estimator: Any) -> float:
    """Return the largest number in the square matrices that an estimator keeps; 0 = it has none.

    Looked at are its attributes, the variables of a closure, and lists and dicts of these.

    Parameters
    ----------
    estimator : object
        The estimator.
    """
    sizes = [abs(one).max() for one in _arrays(estimator, _DEPTH) if _is_square(one)]
    return float(max(sizes, default=0.0))


def line_of_matrix(estimator: EstimatorUnderTest) -> SourceLine | None:
    """Return the last line that sets a square matrix, such as P, or else the definition."""
    kept = _attributes(estimator.made)
    names = [name for name, one in kept.items() if any(map(_is_square, _arrays(one, 1)))]
    return line_that_sets(estimator, names)


def _arrays(value: Any, depth: int) -> Iterator[Floats]:
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and value.size:
            yield value
        return
    if depth == 0 or isinstance(value, (str, bytes, type)):
        return
    if isinstance(value, (list, tuple)) and len(value) < _FEW and (of_lists := _matrix(value)):
        yield from of_lists
        return
    cells = getattr(value, "__closure__", None) or ()
    inner = [cell.cell_contents for cell in cells if _is_filled(cell)]
    inner += value if isinstance(value, (list, tuple)) and len(value) < _FEW else ()
    inner += value.values() if isinstance(value, dict) and len(value) < _FEW else ()
    inner += _attributes(value).values()
    for one in inner:
        yield from _arrays(one, depth - 1)


def _attributes(value: Any) -> dict[str, Any]:
    """Return the attributes of an object, in its dict or its slots."""
    slots = [name for cls in type(value).__mro__ for name in getattr(cls, "__slots__", ())]
    kept = {name: getattr(value, name) for name in slots if hasattr(value, name)}
    return kept | getattr(value, "__dict__", {})


def _matrix(rows: Sequence[Any]) -> list[Floats]:
    """Return lists of lists of numbers as an array; empty = they are something else."""
    if not rows or not all(isinstance(row, (list, tuple)) for row in rows):
        return []
    try:
        return [np.array(rows, dtype=float)]
    except (TypeError, ValueError):
        return []


def _is_filled(cell: Any) -> bool:
    try:
        _ = cell.cell_contents
    except ValueError:
        return False
    return True


def _is_square(values: Floats) -> bool:
    return values.ndim >= 2 and values.shape[-1] == values.shape[-2] > 1
