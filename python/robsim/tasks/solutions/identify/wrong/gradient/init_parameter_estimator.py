"""Wrong: normalised least mean squares, which look at one sample at a time."""

import numpy as np


class Gradient:
    """One step of a gradient for each sample."""

    def __init__(self, theta):
        self.theta = np.array(theta)

    def update(self, phi, y):
        """Return the parameters after one more sample."""
        # theta = theta + mu phi (y - phi' theta) / (1 + phi' phi)
        error = y - (phi * self.theta).sum(axis=1)
        self.theta += 0.5 * phi * (error / (1 + (phi**2).sum(axis=1)))[:, None]
        return self.theta


def init_parameter_estimator(model):
    """Return the estimator."""
    return Gradient(model.theta)
