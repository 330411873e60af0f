"""`Exercise`: a function to write, its right answer, cases, known mistakes, a hint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import check_callable, check_float, check_kind, check_text
from robsim.base.text import quoted

Answer = Callable[..., Any]
Case = tuple[NDArray[Any] | float, ...]
_CASES = 20
_RELATIVE = 1e-6
_MOST_SHOWN = 6  # numbers of an array


@dataclass(frozen=True, kw_only=True)
class Exercise:
    """A function for a student to write, which takes and returns numbers and arrays.

    Attributes
    ----------
    right : callable
        A right answer, named like the exercise.
    cases : callable
        Gets a `numpy.random.Generator`, and returns the arguments of one call as a tuple.
    hint : str
        Help after two wrong answers.
    mistakes : mapping of str to callable
        Known wrong answers, by the sentences for students who give them.
    judge : callable, optional
        Gets a result and the arguments, and returns its fault as a sentence, or None.
        For exercises with many right answers. By default, the result must equal the result of
        `right`.
    tolerance : float
        The allowed absolute difference, in the unit of the result, in addition to a relative
        one of 1e-6.

    Examples
    --------
    An exercise of your own, for `check_answer`:

    >>> def circumference(radius):
    ...     return 2 * np.pi * radius
    >>> mine = robsim.teach.Exercise(
    ...     right=circumference,
    ...     cases=lambda rng: (rng.uniform(1, 2),),
    ...     hint="How many diameters go around a circle?",
    ...     mistakes={"This is the area.": lambda radius: np.pi * radius**2},
    ... )
    >>> robsim.teach.check_answer(lambda radius: np.pi * radius**2, mine).sentences
    ['This is the area.']
    """

    right: Answer
    cases: Callable[[np.random.Generator], Case]
    hint: str
    mistakes: Mapping[str, Answer] = field(default_factory=dict)
    judge: Callable[..., str | None] | None = None
    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        for key in ("right", "cases") if self.judge is None else ("right", "cases", "judge"):
            check_callable(key, getattr(self, key))
        check_text("hint", self.hint)
        check_kind("mistakes", self.mistakes, Mapping)
        for sentence, wrong in self.mistakes.items():
            check_callable(f"mistakes[{quoted(sentence)}]", wrong)
        check_float("tolerance", self.tolerance, minimum=0)

    def __call__(self, *arguments: Any) -> Any:
        """Return the result of the right answer, for other answers that use it."""
        return self.right(*arguments)

    @property
    def name(self) -> str:
        """The name of the function."""
        return self.right.__name__

    @property
    def title(self) -> str:
        """The first line of the function's docstring, without the full stop."""
        return str(self.right.__doc__).splitlines()[0].rstrip(".")


def drawn_cases(exercise: Exercise, seed: int) -> list[Case]:
    """Return the arguments of some calls."""
    rng = np.random.default_rng(seed)
    return [exercise.cases(rng) for _ in range(_CASES)]


def fault_of(exercise: Exercise, cases: Sequence[Case], results: Sequence[Any]) -> str | None:
    """Return the fault in an answer's results as a sentence; None = all are right."""
    faults = (_fault(exercise, *one) for one in zip(cases, results, strict=True))
    found = next(filter(None, faults), None)
    if found is None:
        return None
    for sentence, wrong in exercise.mistakes.items():
        known = (called(wrong, case) for case in cases)
        if all(_alike(*pair, exercise.tolerance) for pair in zip(results, known, strict=True)):
            return sentence
    return found


def _fault(exercise: Exercise, case: Case, result: Any) -> str | None:
    right = called(exercise.right, case)
    if (kind := _kind(result)) != (wanted := _kind(right)):
        return f"{exercise.name} returns {kind}, and must return {wanted}."
    if isinstance(right, np.ndarray):
        if not isinstance(result, np.ndarray):
            return f"{exercise.name} returns a {type(result).__name__}: make it an array, np.array."
        if right.dtype.kind in "iu" and right.max() > 1 and result.dtype.kind == "f":
            return f"{exercise.name} returns decimals: an index is an integer, dtype=int."
        if right.dtype.kind == "b" != result.dtype.kind:
            return f"{exercise.name} returns numbers: a mask has True and False, dtype=bool."
    call = f"{exercise.name}({', '.join(map(_shown, case))})"
    if exercise.judge is not None:
        said = exercise.judge(result, *case)
        return said and f"{call} returns {_shown(result)}: {said}"
    if _alike(result, right, exercise.tolerance):
        return None
    return _difference(call, result, right, exercise.tolerance)


def _difference(call: str, result: Any, right: Any, tolerance: float) -> str:
    """Return a sentence on the first result that differs: one of many numbers, or all of a few."""
    parts = [*zip(_parts(result), _parts(right), strict=True)]
    number = next(n for n, pair in enumerate(parts) if not _alike(*pair, tolerance))
    got, wanted = parts[number]
    which = f"result {number + 1} of {call}" if len(parts) > 1 else call
    if wanted.size <= _MOST_SHOWN:
        return f"{which} is {_two(got, 'and must be', wanted)}."
    near = np.isclose(got, wanted, _RELATIVE, tolerance, equal_nan=True)
    at = tuple(map(int, np.argwhere(~near)[0]))
    two = _two(got[at], "and must be", wanted[at])
    return f"[{', '.join(map(str, at))}] of {which} is {two}."


def _two(got: Any, words: str, wanted: Any) -> str:
    """Return both in a sentence, with enough digits to show their difference."""
    digits = next((n for n in (6, 10) if _shown(got, n) != _shown(wanted, n)), 16)
    return f"{_shown(got, digits)}, {words} {_shown(wanted, digits)}"


def _alike(one: Any, other: Any, tolerance: float) -> bool:
    return _kind(one) == _kind(other) and all(
        np.allclose(a.astype(float), b.astype(float), _RELATIVE, tolerance, equal_nan=True)
        for a, b in zip(_parts(one), _parts(other), strict=True)
    )


def exercise(**options: Any) -> Callable[[Answer], Exercise]:
    """Return a decorator that makes an `Exercise` of its right answer."""
    return lambda right: Exercise(right=right, **options)


def copies(case: Case) -> list[Any]:
    """Return copies of the arguments: numbers and arrays."""
    arrays = (np.array(value) for value in case)
    return [array if array.ndim else array.item() for array in arrays]


def called(answer: Answer, case: Case) -> Any:
    """Return the result of a call with copies of the arguments: numbers, arrays, tuples of both."""
    return answer(*copies(case))


def _parts(result: Any) -> list[NDArray[Any]]:
    """Return the arrays of a result; a tuple of numbers, or a list, is one array."""
    if isinstance(result, tuple) and any(np.ndim(part) for part in result):
        return [np.asarray(part) for part in result]
    return [np.asarray(result)]


def _kind(result: Any) -> str:
    """Return the kind of a result in words: ``"a number"``, ``"an array of shape (3,)"``."""
    if result is None:
        return "None"
    try:
        parts = _parts(result)
    except ValueError:
        return "lists of different lengths"
    if any(part.dtype.kind == "c" for part in parts):
        return "complex numbers"
    if any(part.dtype.kind not in "bifu" for part in parts):
        return f"a {type(result).__name__}"
    kinds = [f"an array of shape {part.shape}" if part.ndim else "a number" for part in parts]
    return kinds[0] if len(kinds) == 1 else f"{len(kinds)} results, {', '.join(kinds)}"


def _shown(value: Any, digits: int = 4) -> str:
    if isinstance(value, tuple) and any(np.ndim(part) for part in value):
        return f"({', '.join(_shown(part, digits) for part in value)})"
    array = np.asarray(value)
    if not array.ndim:
        return f"{array.item():.{digits}g}"
    if array.size > _MOST_SHOWN:
        first = ", ".join(_shown(one, digits) for one in islice(array.flat, 3))
        return f"[{first}, ... of shape {array.shape}]"
    return f"[{', '.join(_shown(one, digits) for one in array)}]"
