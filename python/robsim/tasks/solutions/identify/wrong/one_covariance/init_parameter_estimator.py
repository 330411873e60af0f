"""Wrong: one covariance for all axes, that of x."""

import numpy as np
from recursive_least_squares import RecursiveLeastSquares


class OneCovariance(RecursiveLeastSquares):
    """One whose gain is the same for x, y and the heading."""

    def update(self, phi, y):
        """Return the parameters after one more sample."""
        P = self.P[0]
        K = P @ phi[0] / (1 + phi[0] @ P @ phi[0])
        self.theta += np.outer(y - (phi * self.theta).sum(axis=1), K)
        self.P[0] = P - np.outer(K, phi[0] @ P)
        return self.theta


def init_parameter_estimator(model):
    """Return the estimator."""
    return OneCovariance(model.theta)
