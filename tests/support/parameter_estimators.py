"""Parameter estimators to try the doctor on: right ones in many styles, and usual mistakes."""

from functools import partial

import numpy as np

import robsim


class LeastSquares:
    """Recursive least squares in numpy, three axes at once, in pieces that can be replaced."""

    forgetting = 1.0
    P0 = 1e6

    def __init__(self):
        self.theta, self.P = np.zeros((3, 5)), np.tile(self.P0 * np.eye(5), (3, 1, 1))

    def gain(self, phi):
        Pphi = (self.P @ phi[:, :, None])[:, :, 0]
        return Pphi / (self.forgetting + (phi * Pphi).sum(axis=1, keepdims=True))

    def error(self, phi, y):
        return y - (phi * self.theta).sum(axis=1)

    def reduced(self, K, phi):
        Pphi = (self.P @ phi[:, :, None])[:, :, 0]
        P = (self.P - K[:, :, None] * Pphi[:, None]) / self.forgetting
        return (P + P.transpose(0, 2, 1)) / 2

    def update(self, phi, y):
        K = self.gain(phi)
        self.theta = self.theta + K * self.error(phi, y)[:, None]
        self.P = self.reduced(K, phi)
        return self.theta


class Forgetting(LeastSquares):
    forgetting = 0.99


class Batch:
    """All samples are kept, and fitted anew every 20 samples."""

    def __init__(self):
        self.phi, self.y, self.theta = [], [], np.zeros((3, 5))

    def update(self, phi, y):
        self.phi.append(phi)
        self.y.append(y)
        if len(self.y) % 20 == 0 and len(self.y) < 2000:
            A, b = np.array(self.phi), np.array(self.y)
            self.theta = np.array(
                [np.linalg.lstsq(A[:, i], b[:, i], rcond=None)[0] for i in range(3)]
            )
        return self.theta


class NormalEquations:
    """The sums of phi phi' and phi y, in scaled columns."""

    scale = np.array((100.0, 100, 1, 1, 1))

    def __init__(self):
        self.A, self.b = np.tile(1e-9 * np.eye(5), (3, 1, 1)), np.zeros((3, 5))

    def update(self, phi, y):
        f = phi / self.scale
        self.A = self.A + f[:, :, None] * f[:, None]
        self.b = self.b + f * y[:, None]
        return np.linalg.solve(self.A, self.b[:, :, None])[:, :, 0] / self.scale


class SquareRootFilter:
    """The triangular root of the information, by QR."""

    def __init__(self):
        self.U = np.tile(1e-3 * np.eye(5, 6), (3, 1, 1))

    def update(self, phi, y):
        rows = np.concatenate((phi, y[:, None]), axis=1)
        theta = np.empty((3, 5))
        for i in range(3):
            self.U[i] = np.linalg.qr(np.vstack((self.U[i], rows[i])), mode="r")[:5]
            theta[i] = np.linalg.solve(self.U[i, :, :5], self.U[i, :, 5])
        return theta


class Kalman(LeastSquares):
    """The parameters as a random walk: P grows by a constant."""

    drift = np.diag((1e-9, 1e-9, 1e-9, 1e-9, 1e-9))

    def reduced(self, K, phi):
        return super().reduced(K, phi) + self.drift


class Reset(LeastSquares):
    """P is set to its first value every 300 samples."""

    n = 0

    def update(self, phi, y):
        self.n += 1
        if self.n % 300 == 0:
            self.P = np.tile(self.P0 * np.eye(5), (3, 1, 1))
        return super().update(phi, y)


class Nlms:
    """Normalised least mean squares: slow, as the regressors are nearly dependent."""

    step = 0.5

    def __init__(self):
        self.theta = np.zeros((3, 5))

    def update(self, phi, y):
        e = y - (phi * self.theta).sum(axis=1)
        self.theta = self.theta + (self.step * e / (1e-3 + (phi**2).sum(axis=1)))[:, None] * phi
        return self.theta


class SlowNlms(Nlms):
    step = 0.1


class Displacement(LeastSquares):
    """Estimates the displacement y - x(k-1), and adds 1 to a1."""

    forgetting = 0.995

    def update(self, phi, y):
        return super().update(phi, y - phi[:, 0]) + np.eye(5)[0]


class Differences(LeastSquares):
    """a1 + a2 = 1 is known: x(k-1) - x(k-2) is the regressor."""

    def __init__(self):
        self.theta, self.P = np.zeros((3, 4)), np.tile(1e6 * np.eye(4), (3, 1, 1))

    def update(self, phi, y):
        f = np.column_stack((phi[:, 0] - phi[:, 1], phi[:, 2:]))
        b = super().update(f, y - phi[:, 0])
        return np.column_stack((1 + b[:, 0], -b[:, 0], b[:, 1:]))


class Pooled:
    """x and y have the same parameters: one filter for both, one for the heading."""

    def __init__(self):
        self.filters = [robsim.RecursiveLeastSquares(5) for _ in range(2)]

    def update(self, phi, y):
        plane, heading = self.filters
        for i in range(2):
            plane.update(phi[i], y[i])
        heading.update(phi[2], y[2])
        return np.vstack((plane.theta, plane.theta, heading.theta))


def three_filters():
    filters = [robsim.RecursiveLeastSquares(5, forgetting=0.98) for _ in range(3)]

    def estimate(step):
        if step.sample is None:
            return None
        for one, phi, y in zip(filters, step.sample.phi, step.sample.y, strict=True):
            one.update(phi, y)
        return np.array([one.theta for one in filters])

    return estimate


def generator():
    def running():
        f = Forgetting()
        step = yield None
        while True:
            step = yield step.sample and f.update(step.sample.phi, step.sample.y)

    started = running()
    next(started)
    return lambda step: started.send(step)


class Window:
    """Least squares over the last 60 samples."""

    def __init__(self):
        self.samples, self.theta = [], np.zeros((3, 5))

    def update(self, phi, y):
        self.samples = [*self.samples, (phi, y)][-60:]
        A, b = (np.array(part) for part in zip(*self.samples, strict=True))
        if np.ptp(A[:, 2, 2]) > 0.1:  # the voltages change
            self.theta = np.array(
                [np.linalg.lstsq(A[:, i], b[:, i], rcond=None)[0] for i in range(3)]
            )
        return self.theta


class DeadZone(Forgetting):
    """Samples that are predicted well enough change nothing."""

    def update(self, phi, y):
        e = self.error(phi, y)
        if (abs(e) < (0.05, 0.05, 0.002)).all():
            return self.theta
        return super().update(phi, y)


class LimitedTrace(LeastSquares):
    """Forgetting stops when P is large."""

    def update(self, phi, y):
        self.forgetting = 0.98 if np.trace(self.P, axis1=1, axis2=2).max() < 1e6 else 1.0
        return super().update(phi, y)


class Instruments(LeastSquares):
    """Instrumental variables: the inputs of earlier steps in the place of x(k-2)."""

    before = None

    def update(self, phi, y):
        if self.before is None:
            self.before = phi
        Z = phi.copy()
        Z[:, 1] = self.before[:, 1]
        self.before = phi
        PZ = (self.P @ Z[:, :, None])[:, :, 0]
        K = PZ / (1 + (phi * PZ).sum(axis=1, keepdims=True))
        self.theta = self.theta + K * self.error(phi, y)[:, None]
        phiP = (phi[:, None] @ self.P)[:, 0]
        self.P = self.P - K[:, :, None] * phiP[:, None]
        return self.theta


RIGHT = {
    "RLS": LeastSquares,
    "RLS .99": Forgetting,
    "RLS small P": type("SmallP", (LeastSquares,), {"P0": 1e3}),
    "RLS .98 symmetric": type("Faster", (LeastSquares,), {"forgetting": 0.98}),
    "robsim RLS": partial(robsim.RecursiveLeastSquares, 5, n_filters=3),
    "robsim RLS .99": partial(robsim.RecursiveLeastSquares, 5, n_filters=3, forgetting=0.99),
    "robsim RLS .95": partial(robsim.RecursiveLeastSquares, 5, n_filters=3, forgetting=0.95),
    "robsim RLS .9": partial(robsim.RecursiveLeastSquares, 5, n_filters=3, forgetting=0.9),
    "batch": Batch,
    "normal equations": NormalEquations,
    "square root": SquareRootFilter,
    "Kalman": Kalman,
    "covariance reset": Reset,
    "NLMS": Nlms,
    "slow NLMS": SlowNlms,
    "displacement": Displacement,
    "differences": Differences,
    "x and y pooled": Pooled,
    "three filters": three_filters,
    "generator": generator,
    "window": Window,
    "dead zone": DeadZone,
    "limited trace": LimitedTrace,
    "instruments": Instruments,
}


# --- broken ones -----------------------------------------------------------------------------


class OneSample:
    """Fits the last sample only."""

    def update(self, phi, y):
        return phi * (y / (phi**2).sum(axis=1))[:, None]


class TwoSamples:
    """Fits the last two samples only."""

    def __init__(self):
        self.samples = []

    def update(self, phi, y):
        self.samples = [*self.samples, (phi, y)][-2:]
        A, b = (np.array(part) for part in zip(*self.samples, strict=True))
        return np.array([np.linalg.lstsq(A[:, i], b[:, i], rcond=None)[0] for i in range(3)])


class KeepsP(LeastSquares):
    """Never updates P."""

    def reduced(self, K, phi):
        return self.P


def keeps_p_in_a_closure():
    P, theta = 1e6 * np.eye(5), np.zeros((3, 5))

    def estimate(step):
        nonlocal theta
        if step.sample is None:
            return None
        theta = theta.copy()
        for i, (phi, y) in enumerate(zip(step.sample.phi, step.sample.y, strict=True)):
            K = P @ phi / (1 + phi @ P @ phi)
            theta[i] += K * (y - phi @ theta[i])
        return theta

    return estimate


class ConstantVelocity:
    """No better than 2 x(k-1) - x(k-2)."""

    def __init__(self):
        self.n = 0

    def update(self, phi, y):
        self.n += 1
        theta = np.zeros((3, 5))
        theta[:, :2] = 2, -1
        theta[:, 4] = 1e-6 / self.n
        return theta


class Windup(LeastSquares):
    """Lambda .9 of the textbook, P kept symmetric."""

    forgetting = 0.9


class SlowerWindup(LeastSquares):
    forgetting = 0.93


class Diverges(Forgetting):
    forgetting = 0.99

    def reduced(self, K, phi):
        Pphi = (self.P @ phi[:, :, None])[:, :, 0]
        return (self.P - K[:, :, None] * Pphi[:, None]) / self.forgetting


class SharedP:
    """One P for three axes, updated with each."""

    def __init__(self):
        self.theta, self.P = np.zeros((3, 5)), 1e6 * np.eye(5)

    def update(self, phi, y):
        theta = self.theta.copy()
        for i in range(3):
            K = self.P @ phi[i] / (1 + phi[i] @ self.P @ phi[i])
            theta[i] += K * (y[i] - phi[i] @ theta[i])
            P = self.P - np.outer(K, phi[i] @ self.P)
            self.P = (P + P.T) / 2
        self.theta = theta
        return theta


class SharedFirstP(SharedP):
    """One P for three axes, updated with the first."""

    def update(self, phi, y):
        K = (self.P @ phi.T / (1 + (phi @ self.P * phi).sum(axis=1))).T
        self.theta = self.theta + K * (y - (phi * self.theta).sum(axis=1))[:, None]
        P = self.P - np.outer(K[0], phi[0] @ self.P)
        self.P = (P + P.T) / 2
        return self.theta


class LagOutput(Forgetting):
    """phi of one step, y of the step before."""

    before = None

    def update(self, phi, y):
        if self.before is None:
            self.before = y
        y, self.before = self.before, y
        return super().update(phi, y)


class LagRegressor(Forgetting):
    """y of one step, phi of the step before."""

    before = None

    def update(self, phi, y):
        if self.before is None:
            self.before = phi
        phi, self.before = self.before, phi
        return super().update(phi, y)


def lag_regressor_of_robsim():
    filters = robsim.RecursiveLeastSquares(5, n_filters=3)
    kept = []

    def estimate(step):
        if step.sample is None:
            return None
        kept.append(step.sample.phi)
        return filters.update(kept[-2], step.sample.y) if len(kept) > 1 else np.zeros((3, 5))

    return estimate


def lag_output_of_robsim():
    filters = robsim.RecursiveLeastSquares(5, n_filters=3)
    kept = []

    def estimate(step):
        if step.sample is None:
            return None
        kept.append(step.sample.y)
        return filters.update(step.sample.phi, kept[-2]) if len(kept) > 1 else np.zeros((3, 5))

    return estimate


class SamePhi(Forgetting):
    """The regressor of x for all axes."""

    def update(self, phi, y):
        return super().update(np.tile(phi[0], (3, 1)), y)


class Negative(Forgetting):
    def update(self, phi, y):
        return -super().update(phi, y)


class GainSign(Forgetting):
    def gain(self, phi):
        return -super().gain(phi)


class ErrorSign(Forgetting):
    def error(self, phi, y):
        return -super().error(phi, y)


class RowsExchanged(Forgetting):
    def update(self, phi, y):
        return super().update(phi, y)[[2, 0, 1]]


class InputsExchanged(Forgetting):
    def update(self, phi, y):
        return super().update(phi, y)[:, [0, 1, 3, 2, 4]]


class ColumnsExchanged(Forgetting):
    def update(self, phi, y):
        return super().update(phi, y)[:, [1, 0, 2, 3, 4]]


class ForgetsToAddOne(Displacement):
    def update(self, phi, y):
        return super().update(phi, y) - np.eye(5)[0]


class StopsLearning(Forgetting):
    def reduced(self, K, phi):
        return 0.5 * super().reduced(K, phi)


class HalfTheGain(LeastSquares):
    """The 1 in the denominator is forgotten, and P shrinks without reason."""

    def reduced(self, K, phi):
        return 0.9 * super().reduced(K, phi)


class OneFilterForThree:
    """The three axes of one step as three samples of one filter."""

    def __init__(self):
        self.filter = robsim.RecursiveLeastSquares(5)

    def update(self, phi, y):
        for f, v in zip(phi, y, strict=True):
            self.filter.update(f, v)
        return np.tile(self.filter.theta, (3, 1))


class OtherAxis(LeastSquares):
    """The error of an axis is computed with the parameters of the next one."""

    def error(self, phi, y):
        return y - (phi * self.theta[[1, 2, 0]]).sum(axis=1)


class Swaps(Forgetting):
    """x and y samples are exchanged, but not their regressors."""

    def update(self, phi, y):
        return super().update(phi, y[[1, 0, 2]])


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


class NoInputs(LeastSquares):
    """The voltages are left out."""

    def update(self, phi, y):
        return super().update(phi * (1, 1, 0, 0, 1), y)


class SmallP(LeastSquares):
    """P starts so small that nothing is learned."""

    P0 = 1e-9


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


class WindupInLists(Windup):
    """P as lists of lists, of which numpy knows nothing."""

    def __init__(self):
        super().__init__()
        self.P = self.P.tolist()

    def update(self, phi, y):
        self.P = np.array(self.P)
        theta = super().update(phi, y)
        self.P = self.P.tolist()
        return theta


BROKEN = {
    "whole numbers": (Integers, ["whole numbers"]),
    "one row three times": (OneRow, ["axes mixed"]),
    "no inputs": (NoInputs, ["parameters not learned"]),
    "small P": (SmallP, ["learns nothing"]),
    "windup .9 in slots": (WindupInSlots, ["windup"]),
    "windup .9 in lists": (WindupInLists, ["windup"]),
    "one sample": (OneSample, ["learns nothing"]),
    "two samples": (TwoSamples, ["learns nothing"]),
    "P never updated": (KeepsP, ["learns nothing"]),
    "P never updated, closure": (keeps_p_in_a_closure, ["learns nothing"]),
    "2 x(k-1) - x(k-2)": (ConstantVelocity, ["learns nothing"]),
    "windup .9": (Windup, ["windup"]),
    "windup .93": (SlowerWindup, ["windup"]),
    "asymmetric P": (Diverges, ["diverges"]),
    "one P": (SharedP, ["axes mixed"]),
    "one P of the first axis": (SharedFirstP, ["axes mixed"]),
    "y of the step before": (LagOutput, ["sample mismatched"]),
    "phi of the step before": (LagRegressor, ["sample mismatched"]),
    "phi of the step before, robsim": (lag_regressor_of_robsim, ["sample mismatched"]),
    "y of the step before, robsim": (lag_output_of_robsim, ["sample mismatched"]),
    "phi of x for all": (SamePhi, ["axes mixed"]),
    "theta negated": (Negative, ["wrong sign"]),
    "gain negated": (GainSign, ["wrong sign"]),
    "error negated": (ErrorSign, ["wrong sign"]),
    "rows exchanged": (RowsExchanged, ["order"]),
    "b1 and b2 exchanged": (InputsExchanged, ["order"]),
    "a1 and a2 exchanged": (ColumnsExchanged, ["order"]),
    "1 not added": (ForgetsToAddOne, ["wrong parameters"]),
    "P halved": (StopsLearning, ["learns nothing"]),
    "P shrinks": (HalfTheGain, ["adaptation stops", "learns nothing"]),
    "one filter for three axes": (OneFilterForThree, ["axes mixed"]),
    "one filter of robsim": (partial(robsim.RecursiveLeastSquares, 5), ["refused"]),
    "errors of other axes": (OtherAxis, ["wrong sign"]),
    "x and y exchanged": (Swaps, ["axes mixed"]),
}
