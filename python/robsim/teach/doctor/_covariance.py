"""The check of the covariances that a state estimator returns."""

from __future__ import annotations

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor._lines import line_of_covariance
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial

# Relative to the variances: far above rounding errors, far below the effect of a wrong formula.
_SYMMETRY_TOLERANCE = 1e-6
_MINIMUM_EIGENVALUE = 1e-12


def covariance_problem(estimator: EstimatorUnderTest, trial: Trial) -> Problem | None:
    """Return the first step whose covariance is not symmetric positive definite, and why.

    NEES and every ellipse need its inverse, and a variance of 0 claims exact knowledge.

    Parameters
    ----------
    estimator : EstimatorUnderTest
        The estimator.
    trial : Trial
        The trial with its outputs.
    """
    for k, output in enumerate(trial.outputs):
        fault = fault_of_covariance(output[3:12].reshape(3, 3))
        if fault is not None:
            kind, sentence = fault
            return Problem(
                kind=kind,
                sentence=sentence,
                situation=trial.situation.name,
                k=k,
                line=line_of_covariance(estimator),
            )
    return None


def fault_of_covariance(P: Floats) -> tuple[str, str] | None:
    """Return kind and sentence of what is wrong with a covariance; None = nothing."""
    variances = np.diag(P)
    for name, variance in zip(("x", "y", "heading"), variances, strict=True):
        if variance <= 0:
            return (
                "covariance not positive",
                f"its covariance has the variance {variance:.3g} for {name}: a variance must be "
                "above 0, since a variance of 0 claims exact knowledge",
            )
    # C = P(i, j) / sqrt(P(i, i) P(j, j)), without units
    C = P / np.sqrt(np.outer(variances, variances))
    i, j = np.unravel_index(np.argmax(abs(C - C.T)), C.shape)
    if abs(C[i, j] - C[j, i]) > _SYMMETRY_TOLERANCE:
        return (
            "covariance not symmetric",
            f"its covariance is not symmetric, P[{i}, {j}] = {P[i, j]:.4g} but P[{j}, {i}] = "
            f"{P[j, i]:.4g}: look for a missing transpose, or take P = (P + P.T) / 2",
        )
    minimum = np.linalg.eigvalsh((C + C.T) / 2)[0]
    if minimum < _MINIMUM_EIGENVALUE:
        return (
            "covariance not positive",
            f"its covariance is not positive definite, its correlation matrix has the eigenvalue "
            f"{minimum:.3g}: look for a wrong sign, or P = (I - K H) P with the K of another P",
        )
    return None
