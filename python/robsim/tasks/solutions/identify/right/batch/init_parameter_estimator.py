"""Least squares over all samples, anew in each step."""

import numpy as np


class Batch:
    """All samples by now."""

    def __init__(self):
        self.phi, self.y = [], []

    def update(self, phi, y):
        """Return the parameters that fit all samples best."""
        self.phi.append(phi)
        self.y.append(y)
        phis, ys = np.array(self.phi), np.array(self.y)
        return [np.linalg.lstsq(phis[:, axis], ys[:, axis])[0] for axis in range(3)]


def init_parameter_estimator(model):
    """Return the estimator."""
    return Batch()
