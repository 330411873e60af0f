"""Recursive least squares."""

from recursive_least_squares import RecursiveLeastSquares


def init_parameter_estimator(model):
    """Return the estimator."""
    return RecursiveLeastSquares()
