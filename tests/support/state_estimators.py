"""State estimators to try the doctor on: right ones in many styles, and each usual mistake.

A mistake is a right filter with another piece: a method or a number.
"""

from functools import partial

import numpy as np

import robsim
from robsim.estimation import reference

Q = np.diag((0.1**2, 0.1**2, 0.005**2))
R = np.diag((0.5**2, 0.5**2, 0.01**2))
H = np.eye(3, 6)
PRIOR = np.diag((1e6, 1e6, 10.0, 1e3, 1e3, 1.0))
UNKNOWN = PRIOR[:3, :3]
MIDDLE = np.array((600.0, 600.0, 0.0))


def wrapped(v):
    return np.array((v[0], v[1], robsim.wrap_angle(v[2])))


def seen(step):
    """The measured pose, or None."""
    return None if step.measurement is None else step.measurement.pose


def changed(base, /, **pieces):
    """A filter with other pieces."""
    return type(base.__name__, (base,), pieces)


def altered(base, piece, change):
    """A filter whose piece gives something else."""
    usual = getattr(base, piece)
    return changed(base, **{piece: lambda self, *arguments: change(usual(self, *arguments))})


def by_name(mistakes):
    """{name: (what makes it, the faults of which one must be told)}, of makers by faults."""
    return {
        name: (make, faults.split(" or "))
        for faults, makes in mistakes.items()
        for name, make in makes.items()
    }


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

    Q = np.diag((30.0**2, 30.0**2, 3.0**2))  # of the acceleration

    def matrices(self, dt):
        return (
            np.eye(6) + dt * np.eye(6, k=3),
            np.vstack((np.eye(3) * dt**2 / 2, np.eye(3) * dt)),
        )

    def move(self, u, dt):
        F, G = self.matrices(dt)
        self.x = F @ self.x
        self.P = self.spread(F, self.P) + G @ self.Q @ G.T


# --- right ones ------------------------------------------------------------------------------


def scaled(base, q=1, r=1):
    """A filter whose noises are tuned by other factors."""
    return changed(base, Q=q * base.Q, R=r * base.R)


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
            return robsim.Estimate(wrapped(pose), R if self.window else UNKNOWN)
        t = np.array([time for time, _ in self.window]) - self.now
        A = np.column_stack((np.ones_like(t), t, t**2))
        pose = np.linalg.lstsq(A, np.array([z for _, z in self.window]), rcond=None)[0][0]
        return robsim.Estimate(wrapped(pose), R * np.linalg.inv(A.T @ A)[0, 0])


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


class AlphaBeta:
    """Fixed gains, per step: it needs no dt."""

    alpha, beta = 0.6, 0.2

    def __init__(self):
        self.x, self.way, self.P = None, np.zeros(3), np.diag((1e6, 1e6, 10.0))

    def __call__(self, step):
        z = seen(step)
        if self.x is None:
            if z is not None:
                self.x, self.P = z, R
            return robsim.Estimate(MIDDLE if z is None else z, self.P)
        self.x = self.x + self.way
        self.P = self.P + np.diag((2.0, 2.0, 0.01))
        if z is not None:
            e = wrapped(z - self.x)
            self.x, self.way = self.x + self.alpha * e, self.way + self.beta * e
            self.P = R
        return robsim.Estimate(wrapped(self.x), self.P)


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
        self.motion, self.is_seen = reference.RobotMotion(), False
        self.x, self.P = np.array((600.0, 600, 0, 0, 0, 0)), np.diag((1e4, 1e4, 0.5, 1e2, 1e2, 0.1))

    def __call__(self, step):
        z = seen(step)
        if not self.is_seen:
            if z is None:
                return robsim.Estimate(self.x[:3], UNKNOWN)
            self.is_seen = True
            self.x[:3], self.P[:3, :3] = z, R
            return robsim.Estimate(self.x[:3], self.P[:3, :3])
        L = np.linalg.cholesky(6 * self.P)
        points = self.motion.move(self.x + np.vstack((L.T, -L.T)), step.last_u)
        mean = points.mean(axis=0)
        mean[2] = np.arctan2(np.sin(points[:, 2]).mean(), np.cos(points[:, 2]).mean())
        d = points - mean
        d[:, 2] = robsim.wrap_angle(d[:, 2])
        G = self.motion.G
        self.x, self.P = mean, d.T @ d / 12 + G @ Q @ G.T
        if z is not None:
            S = self.P[:3, :3] + R
            K = np.linalg.solve(S, self.P[:3]).T
            self.x = self.x + K @ wrapped(z - self.x[:3])
            self.P = self.P - K @ S @ K.T
        return robsim.Estimate(wrapped(self.x[:3]), self.P[:3, :3])


def complementary(turn=1.0):
    """Without a matrix: the model's speed, and rate of so many times its own, mixed with z."""
    pose, doubt, speed, rate = np.array((0.0, 0.0, 0.0)), 1e6, 0.0, 0.0

    def estimate(step):
        nonlocal pose, doubt, speed, rate
        left, right = step.last_u
        # m s' + F s = (torques) / radius of the wheels
        speed += step.dt / 0.3 * (0.05 / 0.03 * (left + right) - 0.1 * speed)
        rate += step.dt * (turn * 0.76 * (left - right) - 0.83 * rate)
        v = np.array((speed * np.cos(pose[2]), speed * np.sin(pose[2]), rate))
        pose, doubt = pose + step.dt * v, doubt + step.dt
        if step.measurement is not None:
            pose, doubt = pose + 0.7 * wrapped(step.measurement.pose - pose), 0.5
        return robsim.Estimate(pose, doubt * np.diag((1.0, 1.0, 1e-3)))

    return estimate


class HandsOn:
    """The last measurement, with a covariance that grows: the template."""

    def __init__(self):
        self.pose, self.P = MIDDLE, UNKNOWN

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
        z = seen(step)
        moved = self.model.predict(self.pose, self.before, step.last_u)
        self.before = self.pose
        self.pose = moved if z is None else z
        self.P = self.P + step.dt * np.diag((50.0, 50.0, 0.05)) if z is None else R
        return robsim.Estimate(wrapped(self.pose), self.P)


class RandomWalk:
    """A Kalman filter that takes the robot to stand still; its F is the identity."""

    noise = np.diag((9.0, 9.0, 0.02))

    def __init__(self):
        self.x, self.P = np.zeros(3), UNKNOWN

    def move(self, step):
        self.P = self.P + self.noise

    def __call__(self, step):
        self.move(step)
        if step.measurement is not None:
            K = self.P @ np.linalg.inv(self.P + R)
            self.x = self.x + K @ wrapped(step.measurement.pose - self.x)
            self.P = (np.eye(3) - K) @ self.P
        self.x, self.P = wrapped(self.x), (self.P + self.P.T) / 2
        return robsim.Estimate(self.x, self.P)


class Unicycle(RandomWalk):
    """Three states, and speeds that follow the voltages at once: a crude model."""

    noise = np.diag((1.0, 1.0, 0.003))

    def input(self, step):
        return step.last_u

    def move(self, step):
        left, right = self.input(step)
        v, rate = 16.7 * (left + right), 0.917 * (left - right)
        if step.k > 0:
            c, s = np.cos(self.x[2]), np.sin(self.x[2])
            F = np.array(((1, 0, -v * s * step.dt), (0, 1, v * c * step.dt), (0, 0, 1)))
            self.x = self.x + step.dt * np.array((v * c, v * s, rate))
            self.P = F @ self.P @ F.T + self.noise


class Euler:
    """Five states x, y, heading, speed, rate; the pose moves with the speed before the inputs."""

    H, R = np.eye(3, 5), R
    Q = np.diag((0.3, 0.3, 1e-4, 9.0, 0.03))

    def __init__(self):
        self.x, self.P = None, np.diag((1e5, 1e5, 9.0, 400.0, 1.0))

    def noise(self, step):
        return self.R

    def move(self, u, dt):
        heading, v, w = self.x[2:]
        c, s = np.cos(heading), np.sin(heading)
        self.x = self.x + dt * np.array(
            (v * c, v * s, w, (0.05 / 0.03 * (u[0] + u[1]) - 0.1 * v) / 0.3, 0.76 * (u[0] - u[1]))
        )
        self.x[4] -= dt * 0.83 * w
        F = np.diag((1, 1, 1, 1 - dt / 3, 1 - 0.83 * dt))
        F[0, 2:4], F[1, 2:4], F[2, 4] = (-dt * v * s, dt * c), (dt * v * c, dt * s), dt
        self.P = F @ self.P @ F.T + self.Q

    def reset(self, step):
        pass

    def __call__(self, step):
        z = seen(step)
        if self.x is None:
            self.x = np.array((*MIDDLE, 0.0, 0.0))
        elif step.k:
            self.move(step.last_u, step.dt)
        if z is None:
            self.reset(step)
        else:
            K = self.P @ self.H.T @ np.linalg.inv(self.P[:3, :3] + self.noise(step))
            self.x = self.x + K @ wrapped(z - self.x[:3])
            self.P = (np.eye(5) - K @ self.H) @ self.P
        P = self.P[:3, :3]
        return robsim.Estimate(wrapped(self.x[:3]), (P + P.T) / 2)


RIGHT = {
    "EKF": Ekf,
    "Euler": Euler,
    "EKF 4Q": scaled(Ekf, q=4),
    "EKF R/4": scaled(Ekf, r=0.25),
    "constant velocity": ConstantVelocity,
    "constant velocity Q/4": scaled(ConstantVelocity, q=0.25),
    "window fit": WindowFit,
    "generator": generator,
    "alpha-beta": AlphaBeta,
    "low-pass": changed(AlphaBeta, alpha=0.5, beta=0.0),
    "EKF with a gate": GatedEkf,
    "sigma points": Unscented,
    "complementary": complementary,
    "last pose": HandsOn,
    "dead reckoning": DeadReckoning,
    "unicycle": Unicycle,
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


def at(x, P):
    return robsim.Estimate(x[:3], P[:3, :3])


def measurement_before(self, step):
    """The measurement of the step before."""
    z, self.before = self.before, seen(step)
    return z


def no_krk(self, K, P):
    """Joseph's form without K R K'."""
    A = np.eye(6) - K @ H
    return A @ P @ A.T


def asymmetric(self):
    return at(self.x, self.P + 0.01 * self.P[0, 0] * np.eye(6, k=1))


def predicts_the_next_step(self):
    return at(wrapped(self.x[:3] + 0.2 * self.x[3:]), self.P)


class Mean(HandsOn):
    """The mean of all measurements: a scalar filter of a standing object."""

    n = 0

    def __call__(self, step):
        if step.measurement is not None:
            self.n += 1
            self.pose = self.pose + wrapped(step.measurement.pose - self.pose) / self.n
        return robsim.Estimate(self.pose, R / self.n if self.n else UNKNOWN)


class NoTranspose(Ekf):
    def spread(self, F, P):
        return F @ P @ F


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


def kept(base):
    """A filter with the gain of its first measurement."""

    def gain(self, P):
        self.first = getattr(self, "first", None)
        if self.first is None:
            self.first = base.gain(self, P)
        return self.first

    return changed(base, gain=gain)


def stops(self, step):
    """Take the robot to stand still where it is not seen."""
    self.x[3:] = 0.0


def hidden_again(base):
    """A filter that restarts where the robot is not seen."""

    def call(self, step):
        if step.measurement is None:
            self.__init__()
        return base.__call__(self, step)

    return changed(base, __call__=call)


def twice(base):
    def call(self, step):
        base.__call__(self, step)
        z = self.measured(step)
        if z is not None:
            K = self.gain(self.P)
            self.x = self.x + K @ self.innovation(z)
            self.P = self.reduced(K, self.P)
        return self.result()

    return changed(base, __call__=call)


class TwiceReference(reference.UnscentedKalmanFilter):
    def update(self, z):
        super().update(z)
        super().update(z)


def claims_deviations(base):
    def call(self, step):
        estimate = base.__call__(self, step)
        sigma = np.sqrt(np.diag(estimate.covariance))
        return robsim.Estimate(estimate.pose, np.diag(sigma), estimate.state)

    return changed(base, __call__=call)


def input_before(self, step):
    """The inputs of the step before."""
    u, self.before = self.before, np.array(step.last_u)
    return u


class LateReference(reference.ExtendedKalmanFilter):
    before = np.zeros(2)

    def predict(self, u, dt):
        u, self.before = self.before, np.array(u)
        super().predict(u, dt)


# Pieces that are wrong in the filter with inputs and in that without.
LATE = {"before": None, "measured": measurement_before}
NOT_REDUCED = {"reduced": lambda self, K, P: P}
NO_KRK = {"reduced": no_krk}
UNWRAPPED = {"innovation": lambda self, z: z - self.x[:3]}
SWAPPED = {"input": lambda self, step: step.last_u[::-1]}
ASYMMETRIC = {"result": asymmetric}


def cv(**pieces):
    return changed(ConstantVelocity, **pieces)


# What makes them, by the kind of problem that must be found; "remark:" = words of a remark.
BROKEN = by_name(
    {
        "measurement late": {
            "measurement of the step before": changed(Ekf, **LATE),
            "measurement of the step before, CV": cv(**LATE),
        },
        "covariance not reduced": {"P not reduced": changed(Ekf, **NOT_REDUCED)},
        "covariance reduced too far": {"no K R K', CV": cv(**NO_KRK)},
        "inputs swapped": {
            "inputs swapped": changed(Ekf, **SWAPPED),
            "inputs swapped, unicycle": changed(Unicycle, **SWAPPED),
            "turns the other way, own kinematics": partial(complementary, -1.0),
        },
        "inputs of wrong sign": {"inputs of wrong sign": altered(Ekf, "input", np.negative)},
        "turn missing": {
            "no turn": altered(Ekf, "input", lambda u: np.full(2, np.mean(u))),
            "no turn, own kinematics": partial(complementary, 0.0),
        },
        "inputs late": {
            "inputs two steps old": changed(Ekf, before=np.zeros(2), input=input_before),
            "inputs two steps old, crude": changed(
                Unicycle, before=np.zeros(2), input=input_before
            ),
            "inputs two steps old, reference": LateReference,
        },
        "gain kept": {"first gain": kept(Ekf), "first gain, CV": kept(ConstantVelocity)},
        "state thrown away": {
            "stops unseen": changed(Euler, reset=stops),
            "restarts unseen": hidden_again(ConstantVelocity),
            "restarts unseen, EKF": hidden_again(Ekf),
        },
        "measurement repeated": {
            "updates twice": twice(Ekf),
            "updates twice, CV": twice(ConstantVelocity),
            "updates twice, reported R": TwiceReference,
        },
        "standard deviations": {
            "claims sd": claims_deviations(Ekf),
            "claims sd, CV": claims_deviations(ConstantVelocity),
            "claims sd, reported R": claims_deviations(reference.ParticleFilter),
        },
        "moves too far": {
            "inputs 5 times too large": altered(Ekf, "input", lambda u: 5 * u),
            "predicts twice": changed(Ekf, steps=2),
        },
        "no process noise": {
            "tiny Q": scaled(ConstantVelocity, q=1e-8),
            "mean of all measurements": Mean,
        },
        "remark:standard deviation": {"sd for variance in R": changed(Ekf, R=np.sqrt(R))},
        "covariance too small": {
            "variances squared": cv(R=R**2),
            "claims errors thirty times too small": cv(
                result=lambda self: at(self.x, self.P / 900)
            ),
        },
        "missing transpose": {"F P F": NoTranspose},
        "gain of wrong sign": {
            "gain of wrong sign": altered(ConstantVelocity, "gain", np.negative),
            "innovation of wrong sign": altered(Ekf, "innovation", np.negative),
        },
        "gain too large": {"gain too large": altered(ConstantVelocity, "gain", lambda K: 2.2 * K)},
        "ignores measurement": {
            "heading ignored": altered(ConstantVelocity, "gain", lambda K: K * (1, 1, 0))
        },
        "components exchanged": {
            "x and y exchanged": cv(result=lambda self: at(self.x[[1, 0, 2]], self.P))
        },
        "heading in degrees": {
            "degrees": cv(
                innovation=lambda self, z: wrapped((*z[:2], np.degrees(z[2])) - self.x[:3])
            )
        },
        "heading not wrapped": {"not wrapped, CV": cv(**UNWRAPPED)},
        "covariance not symmetric": {"asymmetric": cv(**ASYMMETRIC)},
        "covariance does not grow": {"P stays": cv(result=lambda self: at(self.x, R))},
        "remark:it never uses step.dt": {
            "dt fixed": cv(move=lambda self, u, dt: ConstantVelocity.move(self, u, 0.2))
        },
        "estimate ahead": {"one step ahead": cv(result=predicts_the_next_step)},
        "lost after a gap": {"gate that never opens": GateOfPixels},
    }
)

# Faults that do not depend on each other: all of them are told.
SEVERAL = (
    (changed(Ekf, **SWAPPED, **NOT_REDUCED), ["inputs swapped", "covariance not reduced"]),
    (cv(**LATE, **ASYMMETRIC), ["measurement late", "covariance not symmetric"]),
    (kept(changed(Ekf, **SWAPPED)), ["inputs swapped", "gain kept"]),
    (claims_deviations(twice(Ekf)), ["standard deviations", "measurement repeated"]),
    (hidden_again(twice(ConstantVelocity)), ["state thrown away", "measurement repeated"]),
)

# What the doctor cannot tell: the estimates are those of a right filter with another Q.
UNTOLD = (cv(steps=2), cv(spread=lambda self, F, P: F.T @ P @ F))
