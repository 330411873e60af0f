"""Whether a covariance can be one."""

from __future__ import annotations

import numpy as np

from robsim._base.check_report import Problem
from robsim._base.checks import Floats
from robsim.doctor._trial import EstimatorUnderTest, Trial

# Both relative to the variances: far above rounding, far below what an error in a formula makes.
_SYMMETRIC = 1e-6
_POSITIVE = 1e-12


def covariance_problem(estimator: EstimatorUnderTest, trial: Trial) -> Problem | None:
    """Return at which step the covariance of a state estimator is none, and why.

    It has to be positive definite: NEES and every ellipse need its inverse, and who claims to know
    a number without any error is wrong.

    Parameters
    ----------
    estimator : EstimatorUnderTest
        The estimator.
    trial : Trial
        What it returned.
    """
    for k, output in enumerate(trial.outputs):
        fault = _fault(output[3:12].reshape(3, 3))
        if fault is not None:
            kind, sentence = fault
            return Problem(
                kind=kind,
                sentence=sentence,
                situation=trial.situation.name,
                step=k,
                line=estimator.line,
            )
    return None


def _fault(P: Floats) -> tuple[str, str] | None:
    """Return kind and sentence."""
    variances = np.diag(P)
    for name, variance in zip(("x", "y", "heading"), variances, strict=True):
        if variance <= 0:
            return (
                "covariance not positive",
                f"its covariance has the variance {variance:.3g} for {name}: a variance is above "
                "0, nothing is known without any error",
            )
    # C = P(i, j) / sqrt(P(i, i) P(j, j)), free of units
    C = P / np.sqrt(np.outer(variances, variances))
    i, j = np.unravel_index(np.argmax(abs(C - C.T)), C.shape)
    if abs(C[i, j] - C[j, i]) > _SYMMETRIC:
        return (
            "covariance not symmetric",
            f"its covariance is not symmetric, P[{i}, {j}] = {P[i, j]:.4g} but P[{j}, {i}] = "
            f"{P[j, i]:.4g}: look for a missing transpose, or take P = (P + P.T) / 2",
        )
    least = np.linalg.eigvalsh((C + C.T) / 2)[0]
    if least < _POSITIVE:
        return (
            "covariance not positive",
            f"its covariance is not positive definite, an eigenvalue of its correlations is "
            f"{least:.3g}: look for a wrong sign, or P = (I - K H) P with a K of another P",
        )
    return None
