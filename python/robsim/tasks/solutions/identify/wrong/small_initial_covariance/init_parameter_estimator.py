"""Wrong: it is sure that all parameters are 0."""

from recursive_least_squares import RecursiveLeastSquares


def init_parameter_estimator(model):
    """Return the estimator."""
    return RecursiveLeastSquares(initial_covariance=0.01)
