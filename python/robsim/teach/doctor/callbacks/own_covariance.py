"""Check whether the covariances of a measurement fit its errors."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.base.report import Column, Row, Table
from robsim.estimation.evaluation.consistency import nees
from robsim.teach.doctor._run_checks import fault_of_covariance
from robsim.teach.doctor._trial import Trial
from robsim.teach.doctor.callbacks.pose_mistakes import are_right

_FEWEST = 12  # measurements
_USUAL = (0.5, 2.0)  # mean NEES / 3 of 30 measurements: 1 +- 0.15, and frames are not all noise
_WRONG = 4.0  # the same, where a filter would follow its measurements to wrong places

_LARGE = 0.1  # mean squared error of a coordinate over its variance: 1 is expected, of 30 +- 0.26

_ADVICE = (
    "give the covariance of the pose, in px^2 and rad^2; robsim.locate(step.blobs, "
    "step.markers, image=step.frame) computes one"
)


def covariance_findings(trial: Trial) -> Iterator[Problem | str | Table]:
    seen = np.isfinite(trial.outputs[:, 0])
    covariances = trial.trace.covariance_measured[: len(seen)]
    given = seen & np.isfinite(covariances).all(axis=(1, 2))
    if seen.any() and not given.any():
        yield (
            "its measurements have no covariance, so their precision is unknown, and state "
            "estimators must assume one: robsim.Measurement(pose, covariance=...); or return the "
            "result of robsim.locate(step.blobs, step.markers, image=step.frame)"
        )
    if not given.any():
        return
    if missing := int((seen & ~given).sum()):
        yield (
            f"{missing} of its {int(seen.sum())} measurements before a noisy camera have no "
            "covariance"
        )
    for k in np.flatnonzero(given):
        if (fault := fault_of_covariance(covariances[k])) is not None:
            yield trial.problem(*fault, int(k))
            return
    is_right = given & are_right(trial.outputs, trial.situation.poses[: len(seen)])
    if is_right.sum() < _FEWEST:
        return
    errors, stated = trial.trace.error[: len(seen)][is_right], covariances[is_right]
    mean = float(np.mean(nees(errors, stated)))
    times = math.sqrt(mean / 3)  # how many times as large as stated the errors are
    verdict = "consistent"
    if mean < 3 * _USUAL[0]:
        verdict = "conservative"
        yield (
            f"its covariances are conservative: the errors are {times:.2g} times as large as "
            "claimed, so a filter makes too little of the measurements"
        )
    elif mean > 3 * _USUAL[1]:
        verdict = "optimistic"
        sentence = (
            f"its covariances are optimistic, too sure: with camera noise the errors are "
            f"{times:.2g} times as large as claimed, so a filter follows noise"
        )
        is_wrong = mean > 3 * _WRONG
        yield trial.problem(verdict, f"{sentence}; {_ADVICE}") if is_wrong else sentence
    if verdict != "conservative":
        yield from _large_variances(errors, stated)
    columns = (
        Column("count", "measurements", ""),
        Column("nees", "mean NEES (3 expected)", "", ".2f"),
        Column("times", "error / stated", "", ".2f"),
        Column("verdict", "verdict", ""),
    )
    row = Row("noise", (int(is_right.sum()), mean, times, verdict))
    yield Table(key="covariances", columns=columns, rows=[row], row_title="covariances")


def _large_variances(errors: Floats, covariances: Floats) -> Iterator[str]:
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    # An exact measurement may have no error, and no variance.
    ratios = np.mean(np.square(errors) / np.maximum(variances, 1e-30), axis=0)
    for name, ratio in zip(("x", "y", "the heading"), ratios, strict=True):
        if ratio < _LARGE:
            yield (
                f"its standard deviation of {name} is {1 / math.sqrt(max(ratio, 1e-12)):.2g} times "
                "the errors, so a filter makes too little of it: variances are in px^2 and rad^2"
            )
