"""Parameter estimators to try the doctor on: right ones in many styles, and usual mistakes.

Most mistakes are the right filter with another piece: a method or a number.
"""

from functools import partial

import numpy as np

import robsim
from state_estimators import altered, by_name, changed


def symmetric(P):
    return (P + np.swapaxes(P, -1, -2)) / 2


def fitted(samples):
    """Least squares, axis by axis, of samples (phi, y)."""
    A, b = (np.array(part) for part in zip(*samples, strict=True))
    return np.array([np.linalg.lstsq(A[:, i], b[:, i], rcond=None)[0] for i in range(3)])


class LeastSquares:
    """Recursive least squares in numpy, three axes at once, in pieces that can be replaced."""

    forgetting = 1.0
    P0 = 1e6

    def __init__(self):
        self.theta, self.P = np.zeros((3, 5)), np.tile(self.P0 * np.eye(5), (3, 1, 1))

    def used(self, phi, y):
        return phi, y

    def gain(self, phi):
        Pphi = (self.P @ phi[:, :, None])[:, :, 0]
        return Pphi / (self.forgetting + (phi * Pphi).sum(axis=1, keepdims=True))

    def error(self, phi, y):
        return y - (phi * self.theta).sum(axis=1)

    def shrunk(self, K, phi):
        Pphi = (self.P @ phi[:, :, None])[:, :, 0]
        return (self.P - K[:, :, None] * Pphi[:, None]) / self.forgetting

    def reduced(self, K, phi):
        return symmetric(self.shrunk(K, phi))

    def result(self):
        return self.theta

    def update(self, phi, y):
        phi, y = self.used(phi, y)
        K = self.gain(phi)
        self.theta = self.theta + K * self.error(phi, y)[:, None]
        self.P = self.reduced(K, phi)
        return self.result()


class Forgetting(LeastSquares):
    forgetting = 0.99


class Batch:
    """All samples are kept, and fitted anew every 20 samples."""

    def __init__(self):
        self.samples, self.theta = [], np.zeros((3, 5))

    def update(self, phi, y):
        self.samples.append((phi, y))
        if len(self.samples) % 20 == 0 and len(self.samples) < 2000:
            self.theta = fitted(self.samples)
        return self.theta


class Nlms:
    """Normalised least mean squares: slow, as the regressors are nearly dependent."""

    step = 0.5

    def __init__(self):
        self.theta = np.zeros((3, 5))

    def update(self, phi, y):
        e = y - (phi * self.theta).sum(axis=1)
        self.theta = self.theta + (self.step * e / (1e-3 + (phi**2).sum(axis=1)))[:, None] * phi
        return self.theta


class Displacement(LeastSquares):
    """Estimates the displacement y - x(k-1), and adds 1 to a1."""

    forgetting = 0.995

    def used(self, phi, y):
        return phi, y - phi[:, 0]

    def result(self):
        return self.theta + np.eye(5)[0]


class Window:
    """Least squares over the last 60 samples."""

    def __init__(self):
        self.samples, self.theta = [], np.zeros((3, 5))

    def update(self, phi, y):
        self.samples = [*self.samples, (phi, y)][-60:]
        if np.ptp([phi[2, 2] for phi, _ in self.samples]) > 0.1:  # the voltages change
            self.theta = fitted(self.samples)
        return self.theta


class DeadZone(Forgetting):
    """Samples that are predicted well enough change nothing."""

    def update(self, phi, y):
        e = self.error(phi, y)
        if (abs(e) < (0.05, 0.05, 0.002)).all():
            return self.theta
        return super().update(phi, y)


class ThreeFilters:
    def __init__(self):
        self.filters = [robsim.RecursiveLeastSquares(5, forgetting=0.98) for _ in range(3)]

    def update(self, phi, y):
        for one, *sample in zip(self.filters, phi, y, strict=True):
            one.update(*sample)
        return np.array([one.theta for one in self.filters])


RIGHT = {
    "RLS": LeastSquares,
    "RLS small P": changed(LeastSquares, P0=1e3),
    "robsim RLS .99": partial(robsim.RecursiveLeastSquares, 5, n_filters=3, forgetting=0.99),
    "robsim RLS .9": partial(robsim.RecursiveLeastSquares, 5, n_filters=3, forgetting=0.9),
    "batch": Batch,
    "NLMS": Nlms,
    "displacement": Displacement,
    "three filters": ThreeFilters,
    "window": Window,
    "dead zone": DeadZone,
}


# --- broken ones -----------------------------------------------------------------------------


class OneSample:
    """Fits the last sample only."""

    def update(self, phi, y):
        return phi * (y / (phi**2).sum(axis=1))[:, None]


class ConstantVelocity:
    """No better than 2 x(k-1) - x(k-2)."""

    def __init__(self):
        self.n = 0

    def update(self, phi, y):
        self.n += 1
        return np.tile((2, -1, 0, 0, 1e-6 / self.n), (3, 1))


class SharedP:
    """One P for three axes, updated with each."""

    def __init__(self):
        self.theta, self.P = np.zeros((3, 5)), 1e6 * np.eye(5)

    def update(self, phi, y):
        theta = self.theta.copy()
        for i in range(3):
            K = self.P @ phi[i] / (1 + phi[i] @ self.P @ phi[i])
            theta[i] += K * (y[i] - phi[i] @ theta[i])
            self.P = symmetric(self.P - np.outer(K, phi[i] @ self.P))
        self.theta = theta
        return theta


def output_before(self, phi, y):
    """phi of one step, y of the step before."""
    before, self.before = self.before, y
    return phi, y if before is None else before


def regressor_before(self, phi, y):
    """y of one step, phi of the step before."""
    before, self.before = self.before, phi
    return phi if before is None else before, y


class Integers(LeastSquares):
    """theta is an array of integers."""

    def update(self, phi, y):
        self.theta = np.trunc(super().update(phi, y))
        return self.theta


class OneRow:
    """[[0.0] * 5] * 3 is one list three times."""

    def __init__(self):
        self.theta, self.P = [[0.0] * 5] * 3, [1e6 * np.eye(5) for _ in range(3)]

    def update(self, phi, y):
        for i in range(3):
            K = self.P[i] @ phi[i] / (1 + phi[i] @ self.P[i] @ phi[i])
            e = y[i] - phi[i] @ self.theta[i]
            for j in range(5):
                self.theta[i][j] += K[j] * e
            self.P[i] = self.P[i] - np.outer(K, phi[i] @ self.P[i])
        return self.theta


class WindupInSlots:
    """P in an attribute without a dict, a matrix for each axis."""

    __slots__ = ("filters", "theta")

    def __init__(self):
        self.theta, self.filters = np.zeros((3, 5)), {i: 1e6 * np.eye(5) for i in range(3)}

    def update(self, phi, y):
        for i, P in self.filters.items():
            K = P @ phi[i] / (0.9 + phi[i] @ P @ phi[i])
            self.theta[i] += K * (y[i] - phi[i] @ self.theta[i])
            P = (P - np.outer(K, phi[i] @ P)) / 0.9
            self.filters[i] = (P + P.T) / 2
        return self.theta


def used(pick):
    return changed(Forgetting, used=lambda self, phi, y: pick(phi, y))


# What makes them, by the kind of problem that must be found.
BROKEN = by_name(
    {
        "whole numbers": {"whole numbers": Integers},
        "parameters not learned": {
            "no inputs": changed(LeastSquares, used=lambda self, phi, y: (phi * (1, 1, 0, 0, 1), y))
        },
        "learns nothing": {
            "small P": changed(LeastSquares, P0=1e-9),
            "one sample": OneSample,
            "P never updated": changed(LeastSquares, reduced=lambda self, K, phi: self.P),
            "2 x(k-1) - x(k-2)": ConstantVelocity,
            "P halved": altered(Forgetting, "reduced", lambda P: P / 2),
        },
        "adaptation stops or learns nothing": {
            "P shrinks": altered(LeastSquares, "reduced", lambda P: 0.9 * P)
        },
        "windup": {
            "windup .9": changed(LeastSquares, forgetting=0.9),
            "windup .9 in slots": WindupInSlots,
        },
        "diverges": {"asymmetric P": changed(Forgetting, reduced=LeastSquares.shrunk)},
        "axes mixed": {
            "one P": SharedP,
            "one row three times": OneRow,
            "phi of x for all": used(lambda phi, y: (np.tile(phi[0], (3, 1)), y)),
            "x and y exchanged": used(lambda phi, y: (phi, y[[1, 0, 2]])),
        },
        "sample mismatched": {
            "y of the step before": changed(Forgetting, before=None, used=output_before),
            "phi of the step before": changed(Forgetting, before=None, used=regressor_before),
        },
        "wrong sign": {
            "theta negated": altered(Forgetting, "result", np.negative),
            "gain negated": altered(Forgetting, "gain", np.negative),
        },
        "order": {
            "rows exchanged": altered(Forgetting, "result", lambda t: t[[2, 0, 1]]),
            "b1 and b2 exchanged": altered(Forgetting, "result", lambda t: t[:, [0, 1, 3, 2, 4]]),
        },
        "wrong parameters": {"1 not added": changed(Displacement, result=LeastSquares.result)},
        "refused": {"one filter of robsim": partial(robsim.RecursiveLeastSquares, 5)},
    }
)
