"""The answers of the notebook 04_estimate, and mistakes that students make."""

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise

UNIT = np.eye(3)
H = np.eye(3, 6)


def covariance(rng, size):
    root = rng.normal(size=(size, size))
    return root @ root.T + np.eye(size)


def matrices(T):
    F = np.block([[UNIT, T * UNIT], [0 * UNIT, UNIT]])
    return F, np.vstack((T**2 / 2 * UNIT, T * UNIT))


def predicted(x, P, T, Q, G):
    F, _ = matrices(T)
    return F @ x, F @ P @ F.T + G @ Q @ G.T


def without_Q(x, P, T, Q):
    F, _ = matrices(T)
    return F @ x, F @ P @ F.T


def without_transpose(x, P, T, Q):
    F, G = matrices(T)
    return F @ x, F @ P @ F + G @ Q @ G.T


def exchanged_transpose(x, P, T, Q):
    F, G = matrices(T)
    return F @ x, F.T @ P @ F + G @ Q @ G.T


def lower_left(x, P, T, Q):
    F, G = matrices(T)
    F = np.block([[UNIT, 0 * UNIT], [T * UNIT, UNIT]])
    return F @ x, F @ P @ F.T + G @ Q @ G.T


def old_P(x, P, T, Q):
    F, G = matrices(T)
    return F @ x, P + G @ Q @ G.T


@exercise(
    cases=lambda rng: (
        rng.normal(size=6),
        covariance(rng, 6),
        rng.uniform(0.5, 2),
        covariance(rng, 3),
    ),
    hint="Write F first: its upper three rows give the pose, its lower three the velocity. G has "
    "the factors of the acceleration in the same rows.",
    mistakes={
        "P does not grow by the acceleration: add its share, G Q G'.": without_Q,
        "P is F P F', with the transposed F on its right.": without_transpose,
        "F and its transpose are exchanged: in F P F' the transposed one is on the right.": (
            exchanged_transpose
        ),
        "T stands in the wrong corner of F: the velocity moves the pose, not the other way.": (
            lower_left
        ),
        "The halves of G are exchanged: the upper one is for the pose.": (
            lambda x, P, T, Q: predicted(x, P, T, Q, np.vstack((T * UNIT, T**2 / 2 * UNIT)))
        ),
        "P is not advanced with F: uncertain velocities make the positions uncertain, too.": old_P,
        "The pose moves by T**2 / 2 times the acceleration; check the upper half of G.": (
            lambda x, P, T, Q: predicted(x, P, T, Q, np.vstack((T**2 * UNIT, T * UNIT)))
        ),
        "The acceleration also displaces the pose: the upper half of G is not 0.": (
            lambda x, P, T, Q: predicted(x, P, T, Q, np.vstack((0 * UNIT, T * UNIT)))
        ),
        "The velocity changes by T times the acceleration; check the lower half of G.": (
            lambda x, P, T, Q: predicted(x, P, T, Q, np.vstack((T**2 / 2 * UNIT, UNIT)))
        ),
    },
)
def kalman_predict(x, P, T, Q):
    """Return state and covariance one step later."""
    F = np.block([[UNIT, T * UNIT], [0 * UNIT, UNIT]])
    G = np.vstack((T**2 / 2 * UNIT, T * UNIT))
    return F @ x, F @ P @ F.T + G @ Q @ G.T


def pose_and_state(rng):
    z = rng.uniform((0, 0, -3.1), (1200, 1200, 3.1))
    return z, rng.uniform((0, 0, -3.1, -50, -50, -1), (1200, 1200, 3.1, 50, 50, 1))


@exercise(
    cases=pose_and_state,
    hint="Subtract first, then look at the third number alone: which function of robsim did you "
    "need for an angle in First drive?",
    mistakes={
        "The difference of the headings leaves the interval from -pi to pi.": (
            lambda z, x: z - x[:3]
        ),
        "It is the prediction minus the measurement: the sign must be the other one.": (
            lambda z, x: -wrapped(z - x[:3])
        ),
        "Prediction minus measurement, and not wrapped: both need a change.": (
            lambda z, x: x[:3] - z
        ),
        "Only the heading is an angle: x and y are not wrapped.": (
            lambda z, x: np.array([robsim.wrap_angle(value) for value in z - x[:3]])
        ),
        "An innovation has a sign: do not take its absolute value.": (
            lambda z, x: np.abs(wrapped(z - x[:3]))
        ),
        "The velocity is not measured: compare with the first three numbers of x.": (
            lambda z, x: wrapped(z - x[3:])
        ),
    },
)
def wrapped_innovation(z, x):
    """Return the innovation of a measured pose."""
    innovation = z - x[:3]
    innovation[2] = robsim.wrap_angle(innovation[2])
    return innovation


def wrapped(difference):
    return np.array([*difference[:2], robsim.wrap_angle(difference[2])])


def gain(P, S):
    return P @ H.T @ np.linalg.inv(S)


def updated(x, P, innovation, S):
    K = gain(P, S)
    return x + K @ innovation, P - K @ S @ K.T


def old_covariance(x, P, innovation, R):
    return x + gain(P, H @ P @ H.T + R) @ innovation, P


def growing(x, P, innovation, R):
    S = H @ P @ H.T + R
    K = gain(P, S)
    return x + K @ innovation, P + K @ S @ K.T


def only_R(x, P, innovation, R):
    S = H @ P @ H.T + R
    K = gain(P, S)
    return x + K @ innovation, P - K @ R @ K.T


def backwards(x, P, innovation, R):
    S = H @ P @ H.T + R
    K = gain(P, S)
    return x - K @ innovation, P - K @ S @ K.T


def each_number_inverted(x, P, innovation, R):
    S = H @ P @ H.T + R
    K = P @ H.T @ (1 / S)
    return x + K @ innovation, P - K @ S @ K.T


def from_zero(x, P, innovation, R):
    S = H @ P @ H.T + R
    K = gain(P, S)
    return K @ innovation, P - K @ S @ K.T


@exercise(
    cases=lambda rng: (
        rng.normal(size=6),
        covariance(rng, 6),
        rng.normal(size=3),
        covariance(rng, 3),
    ),
    hint="One line each: S (3, 3), K (6, 3), then x and P. What are the shapes of your S and K?",
    mistakes={
        "S has only the doubt about the prediction: the measurement counts as exact.": (
            lambda x, P, innovation, R: updated(x, P, innovation, H @ P @ H.T)
        ),
        "S has only the doubt about the measurement: the prediction counts as exact.": (
            lambda x, P, innovation, R: updated(x, P, innovation, R)
        ),
        "1 / S inverts each number: np.linalg.inv(S) inverts the matrix.": each_number_inverted,
        "x moves away from the measurement: check the sign.": backwards,
        "The result is the correction alone: the old x is missing.": from_zero,
        "x is right, P is unchanged: a measurement makes it smaller.": old_covariance,
        "P becomes larger: a measurement makes it smaller.": growing,
        "x is right. In the share that P loses, R stands for S.": only_R,
    },
)
def kalman_update(x, P, innovation, R):
    """Return state and covariance after a measurement."""
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    return x + K @ innovation, P - K @ S @ K.T
