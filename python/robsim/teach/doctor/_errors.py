"""Exceptions in an estimator under test, explained as problems of the report."""

from __future__ import annotations

import inspect
from traceback import TracebackException

from robsim._core import Estimate
from robsim.base.check_report import Problem
from robsim.base.source_line import called_in, line_of_error
from robsim.base.spelling import with_article
from robsim.simulation.callbacks.missing_data import comes_of_none, names_in
from robsim.simulation.callbacks.signatures import accepts, where_defined
from robsim.teach.doctor._trial import TIME_LIMIT, BadResult, EstimatorUnderTest, Trial
from robsim.teach.submissions.imports import NotHereError

#: The kind of problem that a masked name is.
NOT_HERE = "not here"
_READ_ONLY = "read-only"  # numpy has no type for it
_NO_SAMPLE = "step.sample is None at the start, after a bounce and where the robot is not seen"
_NEVER_SEEN = "step.measurement is None before the robot is seen for the first time"
_NOT_SEEN = "step.measurement is None where the robot is not seen"


def problem_of(trial: Trial) -> Problem:
    assert trial.error is not None
    kind, sentence = explained(trial.error)
    missing = _missing(trial)
    if missing is not None and kind not in ("too slow", NOT_HERE):
        kind, reason = missing
        sentence = f"{reason}: then {sentence}"
    elif kind == "exception":
        sentence = "; ".join([sentence, *_hints(trial.error)])
    return trial.problem(kind, sentence, trial.failed_at, line_of_error(trial.error))


def problem_of_make(estimator: EstimatorUnderTest, error: BaseException) -> Problem:
    kind, sentence = explained(error)
    if not accepts(estimator.make, 0):
        kind, sentence = "make fails", _not_a_maker(estimator)
    elif not isinstance(error, (BadResult, NotHereError)):
        kind, sentence = "make fails", f"make() returns no {estimator.slot.noun}: {sentence}"
    return Problem(kind=kind, sentence=sentence, line=line_of_error(error) or estimator.line)


def _not_a_maker(estimator: EstimatorUnderTest) -> str:
    make, name, noun = estimator.make, estimator.name, estimator.slot.noun
    expected = f"make takes no argument and returns a fresh {noun}, got {name}{where_defined(make)}"
    if isinstance(make, type):
        return f"{expected}: write lambda: {name}(...)"
    if inspect.isfunction(make):
        return f"{expected}: for the {noun} itself, write lambda: {name}"
    return f"{expected}, which is {with_article(noun)}; give its class, or lambda: {name}(...)"


def explained(error: BaseException) -> tuple[str, str]:
    text = str(error)
    if isinstance(error, BadResult):
        return error.kind, text
    if isinstance(error, NotHereError):
        return NOT_HERE, text
    if isinstance(error, TimeoutError):
        return "too slow", f"a call takes longer than {TIME_LIMIT:g} s, or never returns"
    if isinstance(error, ValueError) and _READ_ONLY in text:
        return (
            "writes into step",
            "it writes into an array of the step, which is read-only: work on a copy from "
            "np.array(...), and avoid +=, -= and [...] =",
        )
    if isinstance(error, (TypeError, ValueError)) and called_in(error) == Estimate.__name__:
        return "wrong Estimate", f"its Estimate has an invalid value: {text}"
    name = type(error).__name__
    if isinstance(error, (AttributeError, NameError)):
        text = str(TracebackException.from_exception(error))  # with "Did you mean ...?"
    return "exception", f"it raises {name}: {text}" if text else f"it raises {name}"


def _hints(error: BaseException) -> list[str]:
    """Return the notes of an error without the notes about its place."""
    notes = getattr(error, "__notes__", ())
    return [note for note in notes if not note.startswith(("in the callback", "while loading"))]


def _missing(trial: Trial) -> tuple[str, str] | None:
    assert trial.error is not None
    seen, k = trial.situation.measurements, trial.failed_at
    if not seen and comes_of_none(trial.error) and "sample" in names_in(trial.error):
        return "missing sample", _NO_SAMPLE
    if k >= len(seen) or seen[k] is not None:
        return None
    return ("missing measurement", _NOT_SEEN) if any(seen[:k]) else ("not seen yet", _NEVER_SEEN)
