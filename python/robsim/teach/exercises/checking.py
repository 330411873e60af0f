"""`check_answer` and `checked`: whether an answer to an exercise is right, in a sentence."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import nullcontext, redirect_stdout, suppress
from inspect import signature
from io import StringIO
from typing import Any

import numpy as np

from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import check_int, check_text
from robsim.base.source_line import line_of_error
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.simulation.time_limit import TimeLimit
from robsim.teach.errors import SubmissionError
from robsim.teach.exercises.exercise import Answer, Case, Exercise, copies, drawn_cases, fault_of
from robsim.teach.exercises.shipped import notebook_exercises
from robsim.teach.grading import Submission

NOT_WRITTEN = "not written"
_NO_EXERCISE = "answer: unknown exercise"
_HINT_FROM = 2  # failures
_LIMIT = 10.0  # s for a call
_failures: Counter[str] = Counter()


def check_answer(
    answer: Answer | Submission, exercise: str | Exercise | None = None, *, seed: int = 0
) -> CheckReport:
    """Check the answer to an exercise of a notebook.

    Parameters
    ----------
    answer : callable or Submission
        The function of a student, or a submission with a function of that name.
    exercise : str or Exercise, optional
        The exercise, or a name from `notebook_exercises`. Default: the name of the function.
    seed : int
        Seed of the numbers in the cases.

    Returns
    -------
    CheckReport
        True if the answer is right. The report's problem names the fault; its kind is
        ``"not written"`` if the function returns None.

    Raises
    ------
    TypeError, ValueError
        If `answer` is no function or submission, or the exercise is unknown.

    Examples
    --------
    >>> def to_the_right(pose, goal):
    ...     return np.arctan2(goal[1] - pose[1], goal[0] - pose[0]) - pose[2]
    >>> robsim.teach.check_answer(to_the_right).ok
    False
    """
    if not isinstance(answer, Submission) and not callable(answer):
        raise TypeError(f"answer must be a function or a Submission, got {quoted(answer)}")
    if exercise is None:
        exercise = _exercise(getattr(answer, "__name__", ""), _NO_EXERCISE)
    elif not isinstance(exercise, Exercise):
        exercise = _exercise(exercise, "exercise: unknown name")
    cases = drawn_cases(exercise, check_int("seed", seed, minimum=0, maximum=2**63 - 1))
    try:
        if isinstance(answer, Submission):
            results = answer.calls(exercise.name, cases)
        else:
            results = _results(answer, exercise, cases)
    except SubmissionError as error:
        return _report(exercise, "failed", f"{error}.")
    except _ChangedError as changed:
        return _report(exercise, "wrong", str(changed))
    except TimeoutError:
        told = f"{exercise.name} does not end within {_LIMIT:g} s: check its loops."
        return _report(exercise, "failed", told)
    except Exception as error:
        line = line_of_error(error)
        where = f" ({line.place}: {line.text})" if line else ""
        told = f"{exercise.name} raises {type(error).__name__}: {error}{where}."
        return _report(exercise, "failed", told)
    if all(result is None for result in results):
        return _report(exercise, NOT_WRITTEN, f"{exercise.name} returns None.")
    fault = fault_of(exercise, cases, results)
    return CheckReport(name=exercise.name) if fault is None else _report(exercise, "wrong", fault)


def checked(answer: Answer) -> Callable[..., Any]:
    """Print whether the answer to an exercise is right; return this answer or robsim's answer.

    So a notebook continues with the student's function if it is right, else with robsim's function.
    A hint follows the second wrong answer.

    Parameters
    ----------
    answer : callable
        The function of a student, by the name of the exercise.

    Returns
    -------
    callable
        The answer if it is right, else robsim's.

    Raises
    ------
    TypeError, ValueError
        As `check_answer`.

    Examples
    --------
    >>> def to_the_right(pose, goal):
    ...     pass
    >>> to_the_right = robsim.teach.checked(to_the_right)
    to_the_right is not written yet: it returns nothing. Until it is right, this notebook uses an
    answer of robsim.
    """
    exercise = _exercise(getattr(answer, "__name__", ""), _NO_EXERCISE)
    if answer is exercise.right:
        print(f"This {exercise.name} is robsim's: first run the cell with yours again.")
        return answer
    report = check_answer(answer, exercise)
    if report:
        print(f"{exercise.name} is right.")
        return answer
    (problem,) = report.problems
    if problem.kind == NOT_WRITTEN:
        said = "is not written yet: it returns nothing."
    else:
        said = f"is not right yet: {problem.sentence}"
        _failures[exercise.name] += 1
        if _failures[exercise.name] >= _HINT_FROM:
            said += f" Hint: {exercise.hint}"
    told = f"{exercise.name} {said} Until it is right, this notebook uses an answer of robsim."
    print(textwrap.fill(told, 100))
    return exercise.right


def _results(answer: Answer, exercise: Exercise, cases: Sequence[Case]) -> list[Any]:
    """Return the results of all calls; output is printed in the first call only."""
    limit = TimeLimit(_LIMIT)
    call = limit.limited(answer, exercise.name)
    results = []
    with limit.watching():
        for number, case in enumerate(cases):
            given = copies(case)
            with redirect_stdout(StringIO()) if number else nullcontext():
                results.append(call(*given))
            for at, (one, before) in enumerate(zip(given, case, strict=True)):
                if not np.array_equal(one, before, equal_nan=True):
                    raise _ChangedError(
                        f"It changes its argument {_argument(answer, at)}, but the caller still "
                        "needs the argument: work on a copy, with .copy()."
                    )
    return results


def _argument(function: Answer, at: int) -> str:
    """Return the name of an argument, or its number if the function hides its names."""
    with suppress(ValueError, IndexError):
        return [*signature(function).parameters][at]
    return str(at + 1)


class _ChangedError(Exception):
    """An answer has changed an argument."""


def _exercise(name: str, what: str) -> Exercise:
    known = {one.name: one for group in notebook_exercises().values() for one in group}
    check_names(what, [check_text("exercise", name)], known, ValueError)
    return known[name]


def _report(exercise: Exercise, kind: str, sentence: str) -> CheckReport:
    return CheckReport(name=exercise.name, problems=(Problem(kind=kind, sentence=sentence),))
