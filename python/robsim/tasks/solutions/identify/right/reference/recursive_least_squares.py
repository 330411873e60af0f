"""Recursive least squares."""

import numpy as np


class RecursiveLeastSquares:
    """A filter of 5 parameters for each of x, y and the heading."""

    def __init__(self, theta=0.0, initial_covariance=1e6, forgetting=1.0):
        self.theta = np.zeros((3, 5)) + theta
        self.P = np.array([initial_covariance * np.eye(5)] * 3)
        self.forgetting = forgetting

    def update(self, phi, y):
        """Return the parameters after one more sample, phi (3, 5) and y (3,)."""
        for axis in range(3):
            self.update_axis(axis, phi[axis], y[axis])
        return self.theta

    def update_axis(self, axis, phi, y):
        """Take the sample of an axis, phi (5,) and y, into account."""
        P = self.P[axis]
        # K = P phi / (lambda + phi' P phi)
        K = P @ phi / (self.forgetting + phi @ P @ phi)
        # theta = theta + K (y - phi' theta)
        self.theta[axis] += K * (y - phi @ self.theta[axis])
        # P = (P - K phi' P) / lambda, kept symmetric
        P = (P - np.outer(K, phi @ P)) / self.forgetting
        self.P[axis] = (P + P.T) / 2
