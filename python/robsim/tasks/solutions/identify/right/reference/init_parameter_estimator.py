"""Recursive least squares that know nothing at first."""

from recursive_least_squares import RecursiveLeastSquares


def init_parameter_estimator(model):
    """Return the estimator."""
    return RecursiveLeastSquares()
