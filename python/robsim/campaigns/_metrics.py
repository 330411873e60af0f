"""The metrics of a campaign, which compute numbers from the trace of a run."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from robsim.base.checks import check_name
from robsim.base.report import Report
from robsim.base.source_line import inner_of
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.control import score_path, score_pose
from robsim.estimation.evaluation.consistency import pose_consistency
from robsim.estimation.evaluation.errors import pose_errors
from robsim.estimation.identification.batch import batch_estimate
from robsim.trace import PARAMETER_NAMES, Trace

#: A number, numbers by name, or a report that has them.
Numbers = float | Mapping[str, Any] | Report
Metric = Callable[[Trace], Numbers]

_MOST_NUMBERS = 500  # of a metric; SQLite has at most 2000 columns


def _tracking(trace: Trace) -> Numbers:
    statistics = {one.key: one.value for one in trace.tracking().quantities}
    del statistics["steps"]
    return statistics


def _errors(trace: Trace, *, of: str) -> Numbers:
    report = pose_errors(trace, of=of)
    rmse = {f"{name}_rmse": value for name, value in zip(report.names, report.rmse, strict=True)}
    bias = {f"{name}_bias": value for name, value in zip(report.names, report.bias, strict=True)}
    return rmse | bias


def _nees(trace: Trace) -> Numbers:
    report = pose_consistency(trace)
    return {"mean": report.mean, "inside": report.inside}


def _parameters(trace: Trace) -> Numbers:
    trace.require("parameters")
    return dict(zip(PARAMETER_NAMES, trace.parameters[-1].ravel(), strict=True))


def _batch(trace: Trace) -> Numbers:
    return dict(zip(PARAMETER_NAMES, batch_estimate(trace).batch.ravel(), strict=True))


#: The metrics that have a name.
METRICS: dict[str, Metric] = {
    "tracking": _tracking,
    "measurement_errors": functools.partial(_errors, of="measurement"),
    "pose_errors": functools.partial(_errors, of="estimate"),
    "nees": _nees,
    "parameters": _parameters,
    "batch": _batch,
}

#: Scores that need to know the task, as a metric whose arguments are given.
SCORES: dict[str, Callable[..., Numbers]] = {"score_path": score_path, "score_pose": score_pose}


def score_value(name: str, arguments: Mapping[str, Any]) -> Metric:
    """Return one of `SCORES` with its arguments; else raise TypeError or ValueError."""
    check_names("metrics: there is no", [name], SCORES, ValueError)
    known = [one for one in inspect.signature(SCORES[name]).parameters if one != "trace"]
    check_names(f"metrics: {name} has no", arguments, known, ValueError)
    if known[0] not in arguments:
        raise ValueError(f"metrics: {name} must have {known[0]}")
    return functools.partial(SCORES[name], **arguments)


def metrics_value(metrics: Any) -> dict[str, Metric]:
    """Return the option ``metrics`` as functions by name; else raise TypeError or ValueError."""
    if isinstance(metrics, str) or callable(metrics):
        metrics = (metrics,)
    if isinstance(metrics, Mapping):
        named = list(metrics.items())
    elif isinstance(metrics, Iterable):
        named = [(_name_of(metric), metric) for metric in metrics]
    else:
        raise TypeError(f"metrics must be names or functions of the trace, got {quoted(metrics)}")
    if not named:
        raise ValueError("metrics must have at least one metric, got none")
    found: dict[str, Metric] = {}
    for name, metric in named:
        if check_name("metrics", name) in found:
            raise ValueError(
                f"metrics must have different names, got {quoted(name)} twice: give a mapping "
                "of name to function"
            )
        found[name] = _function_of(metric)
    return found


def _name_of(metric: Any) -> str:
    if isinstance(metric, str):
        return metric
    name = getattr(inner_of(metric), "__name__", None)
    if not isinstance(name, str) or name == "<lambda>":
        raise TypeError(
            "metrics must have names: give a mapping of name to function, such as "
            f"{{'final_x': ...}}, got {quoted(metric)}"
        )
    return name


def _function_of(metric: Any) -> Metric:
    if isinstance(metric, str):
        if metric in SCORES:
            raise ValueError(
                f"metrics: {metric} requires arguments: functools.partial("
                f"robsim.control.{metric}, ...)"
            )
        what = "metrics must be functions of the trace, or known by name; there is no"
        check_names(what, [metric], METRICS, ValueError)
        return METRICS[metric]
    if not callable(metric):
        raise TypeError(f"metrics must be names or functions of the trace, got {quoted(metric)}")
    function: Metric = metric
    return function


def numbers_of(
    metrics: Mapping[str, Metric], trace: Trace, taken: frozenset[str]
) -> tuple[dict[str, float], dict[str, BaseException]]:
    """Return the numbers of all metrics by the names of their columns, and others' errors.

    A metric of one number has a column of its name, others have ``NAME_KEY``. A metric that raises,
    returns another type or uses a `taken` column loses only its own numbers.
    """
    numbers: dict[str, float] = {}
    errors: dict[str, BaseException] = {}
    for name, metric in metrics.items():
        try:
            own = {column: _as_float(value) for column, value in _named(name, metric(trace))}
            if before := [column for column in own if column in numbers or column in taken]:
                raise ValueError(f"duplicate column {quoted(before[0])}")
        except (Exception, SystemExit) as error:  # a metric that ends Python fails as others do
            errors[name] = error
        else:
            numbers |= own
    return numbers, errors


def _named(name: str, result: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(result, Report):
        result = dict(_numbers_in(result))
    if not isinstance(result, Mapping):
        yield name, result
        return
    if len(result) > _MOST_NUMBERS:
        raise ValueError(f"a metric must return at most {_MOST_NUMBERS} numbers, got {len(result)}")
    for key, value in result.items():
        yield f"{name}_{check_name('the name of a number', key)}", value


def _numbers_in(report: Report) -> Iterator[tuple[str, Any]]:
    """Yield the numbers of a report, without its texts and intervals."""
    for quantity in report.quantities:
        if quantity.value is None or _is_number(quantity.value):
            yield quantity.key, quantity.value
    for table in report.tables:
        for row in table.rows:
            for column, value in zip(table.columns, row.values, strict=True):
                if value is None or _is_number(value):
                    yield f"{row.title}_{column.key}", value


def _is_number(value: Any) -> bool:
    return isinstance(value, (bool, int, float, np.bool_, np.integer, np.floating))


def _as_float(value: Any) -> float:
    """Return a number as a float, -0 as 0: a store has only one zero."""
    if value is None:
        return math.nan
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if not _is_number(value):
        raise TypeError(
            f"a metric must return a number, a dict of numbers or a Report, got {quoted(value)}"
        )
    return float(value) + 0.0
