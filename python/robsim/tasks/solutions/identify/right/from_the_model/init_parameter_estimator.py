"""Recursive least squares that begin with the parameters of the model."""

from recursive_least_squares import RecursiveLeastSquares


def init_parameter_estimator(model):
    """Return the estimator."""
    return RecursiveLeastSquares(model.theta, initial_covariance=1e3)
