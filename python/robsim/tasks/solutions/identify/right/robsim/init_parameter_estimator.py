"""The recursive least squares of robsim."""

import robsim


def init_parameter_estimator(model):
    """Return the estimator."""
    return robsim.RecursiveLeastSquares(5, n_filters=3)
