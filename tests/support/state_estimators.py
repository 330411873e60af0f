"""State estimators to try the doctor on: right ones in many styles, and each usual mistake."""

from functools import partial

import numpy as np

import robsim
from robsim import reference

Q = np.diag((0.1**2, 0.1**2, 0.005**2))
R = np.diag((0.5**2, 0.5**2, 0.01**2))
H = np.eye(3, 6)
PRIOR = np.diag((1e6, 1e6, 10.0, 1e3, 1e3, 1.0))


def wrapped(v):
    return np.array((v[0], v[1], robsim.wrap_angle(v[2])))


class Ekf:
    """The extended Kalman filter on the robot model, in pieces that a mistake can replace."""

    Q, R = Q, R
    steps = 1  # predictions in a step

    def __init__(self):
        self.motion = reference.RobotMotion()
        self.x, self.P = np.zeros(6), PRIOR

    def input(self, step):
        return step.last_u

    def measured(self, step):
        return None if step.measurement is None else step.measurement.pose

    def spread(self, F, P):
        return F @ P @ F.T

    def gain(self, P):
        return np.linalg.solve(H @ P @ H.T + self.R, H @ P).T

    def reduced(self, K, P):
        A = np.eye(6) - K @ H
        return A @ P @ A.T + K @ self.R @ K.T

    def innovation(self, z):
        return wrapped(z - self.x[:3])

    def move(self, u, dt):
        F, G = self.motion.jacobian(self.x, u), self.motion.G
        self.x = self.motion.move(self.x, u)
        self.P = self.spread(F, self.P) + G @ self.Q @ G.T

    def result(self):
        return robsim.Estimate(wrapped(self.x[:3]), (self.P[:3, :3] + self.P[:3, :3].T) / 2)

    def __call__(self, step):
        for _ in range(self.steps if step.k > 0 else 0):
            self.move(self.input(step), step.dt)
        z = self.measured(step)
        if z is not None:
            K = self.gain(self.P)
            self.x = self.x + K @ self.innovation(z)
            self.P = self.reduced(K, self.P)
        return self.result()


class ConstantVelocity(Ekf):
    """The same without the inputs."""

    acceleration = np.diag((30.0**2, 30.0**2, 3.0**2))

    def move(self, u, dt):
        F = np.eye(6) + dt * np.eye(6, k=3)
        G = np.vstack((np.eye(3) * dt**2 / 2, np.eye(3) * dt))
        self.x = F @ self.x
        self.P = self.spread(F, self.P) + G @ self.acceleration @ G.T


# --- right ones ------------------------------------------------------------------------------


def scaled(base, q, r):
    """A filter whose noises are tuned by other factors."""
    return type(
        f"{base.__name__}{q:g}Q{r:g}R",
        (base,),
        {"Q": q * Q, "acceleration": q * ConstantVelocity.acceleration, "R": r * R},
    )


class SquareRoot(ConstantVelocity):
    """Only the root of P is kept: prediction and update by QR."""

    def __init__(self):
        super().__init__()
        self.L = np.sqrt(PRIOR)

    def __call__(self, step):
        if step.k > 0:
            dt = step.dt
            F = np.eye(6) + dt * np.eye(6, k=3)
            G = np.vstack((np.eye(3) * dt**2 / 2, np.eye(3) * dt))
            self.x = F @ self.x
            stacked = np.vstack(((F @ self.L).T, (G @ np.sqrt(self.acceleration)).T))
            self.L = np.linalg.qr(stacked, mode="r").T
        if step.measurement is not None:
            A = np.zeros((9, 9))
            A[:3, :3] = np.sqrt(R)
            A[3:, :3] = (H @ self.L).T
            A[3:, 3:] = self.L.T
            U = np.linalg.qr(A, mode="r")
            K = np.linalg.solve(U[:3, :3], U[:3, 3:]).T
            self.x = self.x + K @ self.innovation(step.measurement.pose)
            self.L = U[3:, 3:].T
        return robsim.Estimate(wrapped(self.x[:3]), (self.L @ self.L.T)[:3, :3])


class Information:
    """The inverse of P and P^-1 x are kept."""

    def __init__(self):
        self.x, self.Y = np.zeros(6), np.linalg.inv(PRIOR)

    def __call__(self, step):
        F = np.eye(6) + step.dt * np.eye(6, k=3)
        G = np.vstack((np.eye(3) * step.dt**2 / 2, np.eye(3) * step.dt))
        P = F @ np.linalg.inv(self.Y) @ F.T + G @ ConstantVelocity.acceleration @ G.T
        self.Y, x = np.linalg.inv(P + 1e-9 * np.eye(6)), F @ self.x
        if step.measurement is not None:
            z = x[:3] + wrapped(step.measurement.pose - x[:3])
            y = self.Y @ x + H.T @ np.linalg.solve(R, z)
            self.Y = self.Y + H.T @ np.linalg.inv(R) @ H
            x = np.linalg.solve(self.Y, y)
        self.x = x
        P = np.linalg.inv(self.Y)[:3, :3]
        return robsim.Estimate(wrapped(x[:3]), (P + P.T) / 2)


class WindowFit:
    """A parabola through the last eight measurements, evaluated now."""

    def __init__(self):
        self.now, self.window = 0.0, []

    def __call__(self, step):
        self.now += step.dt
        if step.measurement is not None:
            z = step.measurement.pose.copy()
            if self.window:
                z[2] = self.window[-1][1][2] + robsim.wrap_angle(z[2] - self.window[-1][1][2])
            self.window = [*self.window, (self.now, z)][-8:]
        if len(self.window) < 4:
            pose = self.window[-1][1] if self.window else np.zeros(3)
            return robsim.Estimate(wrapped(pose), R if self.window else PRIOR[:3, :3])
        t = np.array([time for time, _ in self.window]) - self.now
        A = np.column_stack((np.ones_like(t), t, t**2))
        pose = np.linalg.lstsq(A, np.array([z for _, z in self.window]), rcond=None)[0][0]
        return robsim.Estimate(wrapped(pose), R * np.linalg.inv(A.T @ A)[0, 0])


def closure():
    """A scalar filter for each component, the speeds taken from the last two estimates."""
    pose, last, P = None, None, PRIOR[:3, :3]

    def estimate(step):
        nonlocal pose, last, P
        z = None if step.measurement is None else step.measurement.pose
        if pose is None:
            if z is None:
                return robsim.Estimate(np.zeros(3), P)
            pose, last, P = z, z, R
            return robsim.Estimate(pose, P)
        ahead = pose + 0.9 * wrapped(pose - last) * step.dt / 0.2
        P = P + step.dt * np.diag((10.0, 10.0, 0.02))
        last = pose
        pose = ahead
        if z is not None:
            k = np.diag(P) / np.diag(P + R)
            pose = wrapped(ahead + k * wrapped(z - ahead))
            P = P @ np.diag(1 - k)
        pose = wrapped(pose)
        return robsim.Estimate(pose, P)

    return estimate


def generator():
    """A coroutine: steps are sent in, estimates come out."""

    def filtering():
        f = ConstantVelocity()
        step = yield None
        while True:
            step = yield f(step)

    running = filtering()
    next(running)
    return lambda step: running.send(step)


class CosSin:
    """The heading is kept as cosine and sine, so that it never needs to be wrapped."""

    def __init__(self):
        self.x, self.rate, self.P = None, 0.0, np.diag((1e6, 1e6, 10.0))
        self.speed = 0.0

    def __call__(self, step):
        z = None if step.measurement is None else step.measurement.pose
        if self.x is None:
            if z is None:
                return robsim.Estimate((600, 600, 0), self.P)
            self.x, self.P = np.array((z[0], z[1], np.cos(z[2]), np.sin(z[2]))), R
            return self.result()
        x, y, c, s = self.x
        turn = self.rate * step.dt
        x, y = x + self.speed * c * step.dt, y + self.speed * s * step.dt
        c, s = c * np.cos(turn) - s * np.sin(turn), s * np.cos(turn) + c * np.sin(turn)
        self.P = self.P + step.dt * np.diag((5.0, 5.0, 0.01))
        if z is not None:
            k = np.diag(self.P) / np.diag(self.P + R)
            along = (z[0] - x) * c + (z[1] - y) * s
            self.speed += 0.3 * along / step.dt
            self.rate += 0.3 * (np.sin(z[2]) * c - np.cos(z[2]) * s) / step.dt
            x, y = x + k[0] * (z[0] - x), y + k[1] * (z[1] - y)
            c, s = c + k[2] * (np.cos(z[2]) - c), s + k[2] * (np.sin(z[2]) - s)
            self.P = self.P @ np.diag(1 - k)
        self.x = np.array((x, y, c, s)) / np.array((1, 1, np.hypot(c, s), np.hypot(c, s)))
        return self.result()

    def result(self):
        x, y, c, s = self.x
        return robsim.Estimate((x, y, np.arctan2(s, c)), self.P)


class AlphaBeta:
    """Fixed gains, per step: it needs no dt."""

    alpha, beta = 0.6, 0.2

    def __init__(self):
        self.x, self.way, self.P = None, np.zeros(3), np.diag((1e6, 1e6, 10.0))

    def __call__(self, step):
        z = None if step.measurement is None else step.measurement.pose
        if self.x is None:
            if z is not None:
                self.x, self.P = z, R
            return robsim.Estimate((600, 600, 0) if z is None else z, self.P)
        self.x = self.x + self.way
        self.P = self.P + np.diag((2.0, 2.0, 0.01))
        if z is not None:
            e = wrapped(z - self.x)
            self.x, self.way = self.x + self.alpha * e, self.way + self.beta * e
            self.P = R
        return robsim.Estimate(wrapped(self.x), self.P)


class AlphaBetaOfTime(AlphaBeta):
    """The same as textbooks have it, with a velocity: x += alpha e, v += beta / T e."""

    def __call__(self, step):
        self.way = self.way * step.dt
        try:
            return super().__call__(step)
        finally:
            self.way = self.way / step.dt


class LowPass(AlphaBeta):
    """x += alpha (z - x)."""

    alpha, beta = 0.5, 0.0


class SlowLowPass(AlphaBeta):
    alpha, beta = 0.25, 0.0

    def __call__(self, step):
        estimate = super().__call__(step)
        return robsim.Estimate(estimate.pose, estimate.covariance + np.diag((40.0, 40.0, 0.05)))


class LineFit:
    """A line through the last measurements, in steps: right for every dt."""

    def __init__(self):
        self.window = []

    def __call__(self, step):
        self.window = [(t - 1, z) for t, z in self.window]
        if step.measurement is not None:
            self.window = [*self.window, (0, step.measurement.pose)][-5:]
        if len(self.window) < 3:
            return robsim.Estimate(
                self.window[-1][1] if self.window else np.zeros(3), PRIOR[:3, :3]
            )
        t, z = (np.array(part) for part in zip(*self.window, strict=True))
        z[:, 2] = np.unwrap(z[:, 2])
        A = np.column_stack((np.ones_like(t), t))
        P = np.linalg.inv(A.T @ A)
        P = 8 * R * P[0, 0] - 0.02 * t[-1] * np.diag((40, 40, 0.1))
        return robsim.Estimate(wrapped(np.linalg.lstsq(A, z, rcond=None)[0][0]), P)


class GatedEkf(Ekf):
    """Innovations that are beyond 6 sigma are left out, but never two in a row."""

    left_out = False

    def innovation(self, z):
        v = super().innovation(z)
        S = H @ self.P @ H.T + self.R
        self.left_out = not self.left_out and bool(v @ np.linalg.solve(S, v) > 36)
        return 0.0 * v if self.left_out else v


class Unscented:
    """Sigma points by hand, with the heading averaged on the circle."""

    def __init__(self):
        self.motion = reference.RobotMotion()
        self.x, self.P = np.array((600.0, 600, 0, 0, 0, 0)), np.diag((1e4, 1e4, 0.5, 1e2, 1e2, 0.1))
        self.is_seen = False

    def __call__(self, step):
        n, kappa = 6, 0.0
        z = None if step.measurement is None else step.measurement.pose
        if not self.is_seen:
            if z is None:
                return robsim.Estimate(self.x[:3], PRIOR[:3, :3])
            self.is_seen = True
            self.x[:3], self.P[:3, :3] = z, R
            return robsim.Estimate(self.x[:3], self.P[:3, :3])
        L = np.linalg.cholesky((n + kappa) * self.P)
        points = self.motion.move(self.x + np.vstack((L.T, -L.T)), step.last_u)
        mean = points.mean(axis=0)
        mean[2] = np.arctan2(np.sin(points[:, 2]).mean(), np.cos(points[:, 2]).mean())
        d = points - mean
        d[:, 2] = robsim.wrap_angle(d[:, 2])
        G = self.motion.G
        self.x, self.P = mean, d.T @ d / (2 * n) + G @ Q @ G.T
        if z is not None:
            S = self.P[:3, :3] + R
            K = np.linalg.solve(S, self.P[:3]).T
            self.x = self.x + K @ wrapped(z - self.x[:3])
            self.P = self.P - K @ S @ K.T
        return robsim.Estimate(wrapped(self.x[:3]), self.P[:3, :3])


class Particles:
    """400 particles around constant velocity, resampled when few are left."""

    def __init__(self):
        self.random = np.random.default_rng(3)
        self.x = None

    def __call__(self, step):
        n, z = 400, None if step.measurement is None else step.measurement.pose
        if self.x is None:
            if z is None:
                return robsim.Estimate((600, 600, 0), PRIOR[:3, :3])
            spread = np.sqrt(np.diag((0.25, 0.25, 1e-4, 30.0, 30.0, 0.2)))
            self.x = np.concatenate((z, np.zeros(3))) + self.random.normal(size=(n, 6)) @ spread
            self.w = np.full(n, 1 / n)
        else:
            a = self.random.normal(size=(n, 3)) * (12.0, 12.0, 1.2)
            self.x[:, :3] += step.dt * self.x[:, 3:] + step.dt**2 / 2 * a
            self.x[:, 3:] += step.dt * a
        if z is not None:
            e = z - self.x[:, :3]
            e[:, 2] = robsim.wrap_angle(e[:, 2])
            log_w = np.log(self.w + 1e-300) - 0.5 * (e**2 / np.diag(2 * R)).sum(axis=1)
            self.w = np.exp(log_w - log_w.max())
            self.w /= self.w.sum()
        center = self.x[self.w.argmax(), 2]
        offset = robsim.wrap_angle(self.x[:, 2] - center)
        poses = np.column_stack((self.x[:, :2], offset))
        mean = self.w @ poses
        d = poses - mean
        P = d.T @ (d * self.w[:, None]) + 0.1 * R
        if 1 / (self.w**2).sum() < n / 2:
            at = np.searchsorted(np.cumsum(self.w), (self.random.random() + np.arange(n)) / n)
            self.x, self.w = self.x[np.minimum(at, n - 1)], np.full(n, 1 / n)
            self.x = self.x + self.random.normal(size=(n, 6)) * (0.1, 0.1, 2e-3, 0.5, 0.5, 0.02)
        return robsim.Estimate(wrapped(mean + np.array((0, 0, center))), P)


def complementary():
    """Without a matrix: the model's speed is mixed with what is seen."""
    pose, doubt, speed = np.array((0.0, 0.0, 0.0)), 1e6, 0.0

    def estimate(step):
        nonlocal pose, doubt, speed
        # m s' + F s = (torques) / radius of the wheels
        speed += step.dt / 0.3 * (0.05 / 0.03 * step.last_u.sum() - 0.1 * speed)
        way = speed * step.dt * np.array((np.cos(pose[2]), np.sin(pose[2]), 0.0))
        pose, doubt = pose + way, doubt + step.dt
        if step.measurement is not None:
            pose, doubt = pose + 0.7 * wrapped(step.measurement.pose - pose), 0.5
        return robsim.Estimate(pose, doubt * np.diag((1.0, 1.0, 1e-3)))

    return estimate


class HandsOn:
    """The last measurement, with a covariance that grows: the template."""

    def __init__(self):
        self.pose, self.P = np.array((600.0, 600.0, 0.0)), PRIOR[:3, :3]

    def __call__(self, step):
        self.P = self.P + step.dt * np.diag((125.0, 125.0, 0.0125))
        if step.measurement is not None:
            self.pose, self.P = step.measurement.pose, R
        return robsim.Estimate(self.pose, self.P)


class DeadReckoning(HandsOn):
    """The last measurement, moved on by the model while there is none."""

    def __init__(self):
        super().__init__()
        self.model, self.before = robsim.RobotModel(), self.pose

    def __call__(self, step):
        z = None if step.measurement is None else step.measurement.pose
        moved = self.model.predict(self.pose, self.before, step.last_u)
        self.before = self.pose
        self.pose = moved if z is None else z
        self.P = self.P + step.dt * np.diag((50.0, 50.0, 0.05)) if z is None else R
        return robsim.Estimate(wrapped(self.pose), self.P)


class Median:
    """The median of the last five measurements."""

    def __init__(self):
        self.seen, self.unseen = [], 1

    def __call__(self, step):
        self.unseen += 1
        if step.measurement is not None:
            self.seen, self.unseen = [*self.seen, step.measurement.pose][-5:], 1
        if not self.seen:
            return robsim.Estimate((600, 600, 0), PRIOR[:3, :3])
        poses = np.array(self.seen)
        poses[:, 2] = poses[-1, 2] + robsim.wrap_angle(poses[:, 2] - poses[-1, 2])
        P = self.unseen * np.diag((40.0, 40.0, 0.05))
        return robsim.Estimate(wrapped(np.median(poses, axis=0)), P)


class Holt:
    """Double exponential smoothing, step by step."""

    def __init__(self):
        self.level, self.trend, self.unseen = None, np.zeros(3), 1

    def __call__(self, step):
        z = None if step.measurement is None else step.measurement.pose
        if self.level is None:
            self.level = z
            return robsim.Estimate((600, 600, 0) if z is None else z, PRIOR[:3, :3])
        self.unseen, ahead = self.unseen + 1, self.level + self.trend
        if z is not None:
            level = ahead + 0.5 * wrapped(z - ahead)
            self.trend = self.trend + 0.3 * (level - self.level - self.trend)
            self.unseen, ahead = 1, level
        self.level = ahead
        return robsim.Estimate(wrapped(ahead), 4 * self.unseen**2 * R)


def random_walk():
    """A Kalman filter that takes the robot to stand still; its F is the identity."""
    x, P, F = np.zeros(3), 1e6 * np.eye(3), np.eye(3)

    def estimate(step):
        nonlocal x, P
        P = F @ P @ F + np.diag((9.0, 9.0, 0.02))
        if step.measurement is not None:
            K = P @ np.linalg.inv(P + R)
            x = x + K @ wrapped(step.measurement.pose - x)
            P = (np.eye(3) - K) @ P
        return robsim.Estimate(wrapped(x), (P + P.T) / 2)

    return estimate


class Unicycle:
    """Three states, and speeds that follow the voltages at once: a crude model."""

    def __init__(self):
        self.x, self.P = np.zeros(3), PRIOR[:3, :3]

    def input(self, step):
        return step.last_u

    def __call__(self, step):
        left, right = self.input(step)
        v, rate = 16.7 * (left + right), 0.917 * (left - right)
        if step.k > 0:
            c, s = np.cos(self.x[2]), np.sin(self.x[2])
            F = np.array(((1, 0, -v * s * step.dt), (0, 1, v * c * step.dt), (0, 0, 1)))
            self.x = self.x + step.dt * np.array((v * c, v * s, rate))
            self.P = F @ self.P @ F.T + np.diag((1.0, 1.0, 0.003))
        if step.measurement is not None:
            K = self.P @ np.linalg.inv(self.P + R)
            self.x = self.x + K @ wrapped(step.measurement.pose - self.x)
            self.P = (np.eye(3) - K) @ self.P
        self.x, self.P = wrapped(self.x), (self.P + self.P.T) / 2
        return robsim.Estimate(self.x, self.P)


class Robust(ConstantVelocity):
    """Large innovations count less (Huber)."""

    def innovation(self, z):
        v = super().innovation(z)
        sigma = np.sqrt(np.diag(H @ self.P @ H.T + self.R))
        return np.clip(v, -3 * sigma, 3 * sigma)


class Adaptive(ConstantVelocity):
    """R follows the innovations."""

    def innovation(self, z):
        v = super().innovation(z)
        self.R = np.diag(0.98 * np.diag(self.R) + 0.02 * np.clip(v**2, 0, np.diag(4 * R)))
        return v


class Sequential(Ekf):
    """The three components are used one after the other."""

    def __call__(self, step):
        if step.k > 0:
            self.move(step.last_u, step.dt)
        if step.measurement is not None:
            v, x = self.innovation(step.measurement.pose), np.zeros(6)
            for i in range(3):
                K = self.P[:, i] / (self.P[i, i] + R[i, i])
                x = x + K * (v[i] - x[i])
                self.P = self.P - np.outer(K, self.P[i])
            self.x = self.x + x
        return self.result()


class Acceleration(Ekf):
    """Constant accelerations: nine states."""

    def __init__(self):
        super().__init__()
        self.x, self.P = np.zeros(9), np.diag((1e6, 1e6, 10, 1e3, 1e3, 1, 1e2, 1e2, 1.0))

    def __call__(self, step):
        dt, H9 = step.dt, np.eye(3, 9)
        F = np.eye(9) + dt * np.eye(9, k=3) + dt**2 / 2 * np.eye(9, k=6)
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + dt * np.diag((0, 0, 0, 0, 0, 0, 400.0, 400.0, 4.0))
        if step.measurement is not None:
            K = np.linalg.solve(H9 @ self.P @ H9.T + R, H9 @ self.P).T
            self.x = self.x + K @ wrapped(step.measurement.pose - self.x[:3])
            A = np.eye(9) - K @ H9
            self.P = A @ self.P @ A.T + K @ R @ K.T
        return robsim.Estimate(wrapped(self.x[:3]), self.P[:3, :3])


RIGHT = {
    "EKF": Ekf,
    "EKF Q/4": scaled(Ekf, 0.25, 1),
    "EKF 4Q": scaled(Ekf, 4, 1),
    "EKF R/4": scaled(Ekf, 1, 0.25),
    "EKF 4R": scaled(Ekf, 1, 4),
    "constant velocity": ConstantVelocity,
    "constant velocity Q/4": scaled(ConstantVelocity, 0.25, 1),
    "constant velocity 4Q": scaled(ConstantVelocity, 4, 1),
    "constant velocity R/4": scaled(ConstantVelocity, 1, 0.25),
    "constant velocity 4R": scaled(ConstantVelocity, 1, 4),
    "constant acceleration": Acceleration,
    "square root by QR": SquareRoot,
    "information": Information,
    "window fit": WindowFit,
    "line fit": LineFit,
    "closure": closure,
    "generator": generator,
    "cosine and sine": CosSin,
    "alpha-beta": AlphaBeta,
    "alpha-beta with dt": AlphaBetaOfTime,
    "low-pass": LowPass,
    "slow low-pass": SlowLowPass,
    "EKF with a gate": GatedEkf,
    "sigma points": Unscented,
    "particles": Particles,
    "complementary": complementary,
    "last pose": HandsOn,
    "dead reckoning": DeadReckoning,
    "median": Median,
    "Holt": Holt,
    "random walk": random_walk,
    "unicycle": Unicycle,
    "Huber": Robust,
    "adaptive R": Adaptive,
    "one component after the other": Sequential,
    "reference constant velocity": reference.ConstantVelocityKalmanFilter,
    "reference EKF": reference.ExtendedKalmanFilter,
    "reference UKF": reference.UnscentedKalmanFilter,
    "reference particles": reference.ParticleFilter,
    "EKF for a sharper camera": partial(
        reference.ExtendedKalmanFilter, measurement_sigma=(0.05, 0.05, 0.002)
    ),
    "EKF without process noise": partial(
        reference.ExtendedKalmanFilter, process_sigma=(0, 0, 0), measurement_sigma=(0.5, 0.5, 0.01)
    ),
}


# --- broken ones -----------------------------------------------------------------------------


class Late(Ekf):
    """Uses the measurement of the step before."""

    before = None

    def measured(self, step):
        z, self.before = self.before, super().measured(step)
        return z


class LateConstantVelocity(ConstantVelocity):
    queue = ()

    def measured(self, step):
        self.queue = (*self.queue, super().measured(step))[-2:]
        return self.queue[0] if len(self.queue) > 1 else None


def late_alpha_beta():
    f, kept = AlphaBeta(), []

    def estimate(step):
        result = kept.pop() if kept else robsim.Estimate((600, 600, 0), PRIOR[:3, :3])
        kept.append(f(step))
        return result

    return estimate


class NotReduced(Ekf):
    """P is not reduced by a measurement."""

    def reduced(self, K, P):
        return P


class NotReducedConstantVelocity(ConstantVelocity):
    def reduced(self, K, P):
        return P


class Swapped(Ekf):
    """u2 is taken for the left motor."""

    def input(self, step):
        return step.last_u[::-1]


class Negated(Ekf):
    def input(self, step):
        return -step.last_u


class TurnsTheOtherWay(Ekf):
    """The heading is taken as counter-clockwise in the model."""

    def move(self, u, dt):
        super().move(np.array((u[1], u[0])), dt)


def swapped_complementary():
    """Its own kinematics, with the heading's rate of wrong sign."""
    pose, speed, rate, doubt = np.array((0.0, 0.0, 0.0)), 0.0, 0.0, 1e6

    def estimate(step):
        nonlocal pose, speed, rate, doubt
        left, right = step.last_u
        speed += step.dt / 0.3 * (0.05 / 0.03 * (left + right) - 0.1 * speed)
        rate += step.dt * (0.76 * (right - left) - 0.83 * rate)
        v = np.array((speed * np.cos(pose[2]), speed * np.sin(pose[2]), rate))
        pose, doubt = pose + step.dt * v, doubt + step.dt
        if step.measurement is not None:
            pose, doubt = pose + 0.7 * wrapped(step.measurement.pose - pose), 0.5
        return robsim.Estimate(pose, doubt * np.diag((1.0, 1.0, 1e-3)))

    return estimate


class NoKRK(Ekf):
    """Joseph's form without K R K'."""

    def reduced(self, K, P):
        A = np.eye(6) - K @ H
        return A @ P @ A.T


class NoKRKConstantVelocity(ConstantVelocity):
    def reduced(self, K, P):
        A = np.eye(6) - K @ H
        return A @ P @ A.T


class NoQ(ConstantVelocity):
    acceleration = np.zeros((3, 3))


class TinyQ(ConstantVelocity):
    acceleration = 1e-8 * ConstantVelocity.acceleration


class NoQOnceStarted(HandsOn):
    """A scalar filter of a standing object."""

    def __init__(self):
        super().__init__()
        self.n = 0

    def __call__(self, step):
        if step.measurement is not None:
            self.n += 1
            self.pose = self.pose + wrapped(step.measurement.pose - self.pose) / self.n
        return robsim.Estimate(self.pose, R / max(self.n, 1e-3) if self.n else PRIOR[:3, :3])


class DeviationForVariance(Ekf):
    """The standard deviations stand in R."""

    R = np.sqrt(R)


class DeviationForVarianceConstantVelocity(ConstantVelocity):
    R = np.sqrt(R)


class SquaredTwice(ConstantVelocity):
    """The variances are squared again."""

    R = np.diag(np.diag(R) ** 2)


class Twice(Ekf):
    """Predicts twice."""

    steps = 2


class TwiceConstantVelocity(ConstantVelocity):
    steps = 2


class DoubleDt(ConstantVelocity):
    def move(self, u, dt):
        super().move(u, 2 * dt)


class NoTranspose(Ekf):
    """F P F."""

    def spread(self, F, P):
        return F @ P @ F


class NoTransposeConstantVelocity(ConstantVelocity):
    def spread(self, F, P):
        return F @ P @ F


class TransposesTheOther(ConstantVelocity):
    """F' P F."""

    def spread(self, F, P):
        return F.T @ P @ F


class GainSign(ConstantVelocity):
    def gain(self, P):
        return -super().gain(P)


class GainTwice(ConstantVelocity):
    def gain(self, P):
        return 2.2 * super().gain(P)


class InnovationSign(Ekf):
    def innovation(self, z):
        return wrapped(self.x[:3] - z)


class SwapsXAndY(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[[1, 0, 2]], self.P[:3, :3])


class Degrees(ConstantVelocity):
    def innovation(self, z):
        return super().innovation(np.array((z[0], z[1], np.degrees(z[2]))))


class Unwrapped(Ekf):
    def innovation(self, z):
        return z - self.x[:3]


class UnwrappedConstantVelocity(ConstantVelocity):
    def innovation(self, z):
        return z - self.x[:3]


class Asymmetric(ConstantVelocity):
    def result(self):
        P = self.P[:3, :3].copy()
        P[0, 1] += 0.01 * P[0, 0]
        return robsim.Estimate(self.x[:3], P)


class NeverDoubts(ConstantVelocity):
    def result(self):
        return robsim.Estimate(self.x[:3], R)


class TooSure(ConstantVelocity):
    """Claims errors that are thirty times too small."""

    def result(self):
        return robsim.Estimate(self.x[:3], self.P[:3, :3] / 900)


class FixedDt(ConstantVelocity):
    def move(self, u, dt):
        super().move(u, 0.2)


class IgnoresHeading(ConstantVelocity):
    """Only the measured place is used."""

    def gain(self, P):
        return super().gain(P) * (1, 1, 0)


class Ahead(ConstantVelocity):
    """Returns the prediction for the next step."""

    def result(self):
        pose = self.x[:3] + 0.2 * self.x[3:]
        return robsim.Estimate(wrapped(pose), self.P[:3, :3])


class GateOfPixels(HandsOn):
    """Leaves out what is farther than 20 px from the last pose, for ever."""

    is_seen = False

    def __call__(self, step):
        self.P = self.P + step.dt * np.diag((125.0, 125.0, 0.0125))
        if step.measurement is not None:
            z = step.measurement.pose
            if not self.is_seen or np.hypot(*(z - self.pose)[:2]) < 20:
                self.pose, self.P, self.is_seen = z, R, True
        return robsim.Estimate(self.pose, self.P)


class SwappedUnicycle(Unicycle):
    def input(self, step):
        return step.last_u[::-1]


class TooMuchInput(Ekf):
    """Volts are taken for something ten times as large."""

    def input(self, step):
        return 5 * step.last_u


class SwappedAndNotReduced(Swapped, NotReduced):
    pass


class LateAndAsymmetric(LateConstantVelocity, Asymmetric):
    pass


class UnwrappedAndNoKRK(Unwrapped, NoKRK):
    pass


# The kinds of problems of which one must be found; "remark:" = words of a remark.
BROKEN = {
    "measurement of the step before": (Late, ["measurement late"]),
    "measurement of the step before, CV": (LateConstantVelocity, ["measurement late"]),
    "estimate of the step before": (late_alpha_beta, ["measurement late"]),
    "P not reduced": (NotReduced, ["covariance not reduced"]),
    "P not reduced, CV": (NotReducedConstantVelocity, ["covariance not reduced"]),
    "inputs swapped": (Swapped, ["inputs swapped"]),
    "inputs of wrong sign": (Negated, ["inputs of wrong sign"]),
    "turns the other way": (TurnsTheOtherWay, ["inputs swapped"]),
    "turns the other way, own kinematics": (swapped_complementary, ["inputs swapped"]),
    "inputs swapped, unicycle": (SwappedUnicycle, ["inputs swapped"]),
    "inputs 5 times too large": (TooMuchInput, ["moves too far"]),
    "no K R K'": (NoKRK, ["covariance reduced too far"]),
    "no K R K', CV": (NoKRKConstantVelocity, ["covariance reduced too far"]),
    "no Q": (NoQ, ["no process noise"]),
    "tiny Q": (TinyQ, ["no process noise"]),
    "mean of all measurements": (NoQOnceStarted, ["no process noise"]),
    "sd for variance in R": (DeviationForVariance, ["remark:standard deviation"]),
    "sd for variance in R, CV": (
        DeviationForVarianceConstantVelocity,
        ["remark:standard deviation"],
    ),
    "variances squared": (SquaredTwice, ["covariance too small"]),
    "predicts twice": (Twice, ["moves too far"]),
    "F P F": (NoTranspose, ["missing transpose"]),
    "F P F, CV": (NoTransposeConstantVelocity, ["missing transpose"]),
    "gain of wrong sign": (GainSign, ["gain of wrong sign"]),
    "gain too large": (GainTwice, ["gain too large"]),
    "innovation of wrong sign": (InnovationSign, ["gain of wrong sign"]),
    "x and y exchanged": (SwapsXAndY, ["components exchanged"]),
    "degrees": (Degrees, ["heading in degrees"]),
    "not wrapped": (Unwrapped, ["heading not wrapped"]),
    "not wrapped, CV": (UnwrappedConstantVelocity, ["heading not wrapped"]),
    "asymmetric": (Asymmetric, ["covariance not symmetric"]),
    "P stays as it is": (NeverDoubts, ["covariance does not grow"]),
    "claims errors thirty times too small": (TooSure, ["covariance too small"]),
    "dt fixed": (FixedDt, ["remark:it never uses step.dt"]),
    "heading ignored": (IgnoresHeading, ["ignores measurement"]),
    "one step ahead": (Ahead, ["estimate ahead"]),
    "gate that never opens": (GateOfPixels, ["lost after a gap"]),
}

# Faults that do not depend on each other: all of them are told.
SEVERAL = {
    SwappedAndNotReduced: ["inputs swapped", "covariance not reduced"],
    LateAndAsymmetric: ["measurement late", "covariance not symmetric"],
    UnwrappedAndNoKRK: ["covariance reduced too far", "heading not wrapped"],
}

# What the doctor cannot tell: the estimates are those of a right filter with another Q.
UNTOLD = {
    "predicts twice, CV": TwiceConstantVelocity,  # and takes the velocities for half as large
    "dt doubled, CV": DoubleDt,
    "F' P F, CV": TransposesTheOther,
}
