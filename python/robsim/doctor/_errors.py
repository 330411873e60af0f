"""Exceptions in an estimator under test, explained as problems of the report."""

from __future__ import annotations

import re

from robsim._base.check_report import Problem
from robsim._base.source_line import line_of_error
from robsim.doctor._trial import TIME_LIMIT, BadResult, EstimatorUnderTest, Trial

_REJECTED = re.compile(r"(pose|covariance|state) must be ")
_NO_SAMPLE = "step.sample is None at the start, after a bounce and where the robot is not seen"
_NEVER_SEEN = "step.measurement is None before the robot is seen for the first time"
_NOT_SEEN = "step.measurement is None where the robot is not seen"


def problem_of(estimator: EstimatorUnderTest, trial: Trial) -> Problem:
    """Return the error that ended a trial, as a problem."""
    assert trial.error is not None
    kind, sentence = _explained(trial.error)
    missing = _missing(trial)
    if missing is not None and kind != "too slow":
        kind, reason = missing
        sentence = f"{reason}: then {sentence}"
    return Problem(
        kind=kind,
        sentence=sentence,
        situation=trial.situation.name,
        k=trial.failed_at,
        line=line_of_error(trial.error) or estimator.line,
    )


def problem_of_make(estimator: EstimatorUnderTest, error: BaseException) -> Problem:
    """Return the error that kept make() from returning an estimator, as a problem."""
    kind, sentence = _explained(error)
    if not isinstance(error, BadResult):
        kind, sentence = "make fails", f"make() returns no estimator: {sentence}"
    if isinstance(error, TypeError) and "argument" in str(error):
        sentence += "; make takes no argument and returns a fresh estimator, such as its class"
    return Problem(kind=kind, sentence=sentence, line=line_of_error(error) or estimator.line)


def _explained(error: BaseException) -> tuple[str, str]:
    """Return kind and sentence of an error."""
    text = str(error)
    if isinstance(error, BadResult):
        return error.kind, text
    if isinstance(error, TimeoutError):
        return "too slow", f"a call takes longer than {TIME_LIMIT:g} s, or never ends"
    if isinstance(error, ValueError) and "read-only" in text:
        return (
            "writes into step",
            "it writes into an array of the step, which is read-only: work on a copy, such as "
            "np.array(...), and beware of +=, -= and [...] =",
        )
    if isinstance(error, (TypeError, ValueError)) and _REJECTED.match(text):
        if "all finite" in text:
            return "not finite", f"its Estimate has a value that is not finite: {text}"
        return "output shape", f"its Estimate has a value of the wrong type or shape: {text}"
    name = type(error).__name__
    return "exception", f"it raises {name}: {text}" if text else f"it raises {name}"


def _missing(trial: Trial) -> tuple[str, str] | None:
    """Return kind and sentence if the step had no data, which may have caused the error."""
    seen, k = trial.situation.measurements, trial.failed_at
    if not seen and k < 2 and "None" in str(trial.error):
        return "missing sample", _NO_SAMPLE
    if k >= len(seen) or seen[k] is not None:
        return None
    return ("missing measurement", _NOT_SEEN) if any(seen[:k]) else ("not seen yet", _NEVER_SEEN)
