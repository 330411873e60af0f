"""Wrong: it never updates the covariance."""

from recursive_least_squares import RecursiveLeastSquares


class ConstantCovariance(RecursiveLeastSquares):
    """One that learns as fast at the end as at first."""

    def update_axis(self, axis, phi, y):
        """Take the sample of an axis into account, and forget how much is known by it."""
        P = self.P[axis].copy()
        super().update_axis(axis, phi, y)
        self.P[axis] = P


def init_parameter_estimator(model):
    """Return the estimator."""
    return ConstantCovariance(model.theta)
