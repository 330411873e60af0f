"""The answers of the notebook 13_extended_kalman_filter, and mistakes that students make."""

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise

MODEL = robsim.RobotModel()
OFFSETS = 0.1 * np.eye(3, 5, 4)  # so that d1 counts


def state_and_input(rng):
    pose = rng.uniform((200, 200, -1), (900, 900, 1))
    return np.append(pose, pose - rng.uniform(1, 5, 3) * (1, 1, 0.02)), rng.uniform(-1, 1, 2)


@exercise(
    cases=state_and_input,
    tolerance=1e-7,
    hint="state[:3] is the pose, state[3:] the previous pose. Which of them is in the next state?",
    mistakes={
        "The old pose moves to the second place: yours keeps the oldest one.": (
            lambda state, u: np.append(MODEL.predict(state[:3], state[3:], u), state[3:])
        ),
        "The model gets the newer pose first.": lambda state, u: np.append(
            MODEL.predict(state[3:], state[:3], u), state[:3]
        ),
        "The new pose comes first in the state.": lambda state, u: np.append(
            state[:3], MODEL.predict(state[:3], state[3:], u)
        ),
        "The state has six numbers: the new pose and the old one.": (
            lambda state, u: MODEL.predict(state[:3], state[3:], u)
        ),
        "The inputs are missing.": lambda state, u: np.append(
            MODEL.predict(state[:3], state[3:], (0, 0)), state[:3]
        ),
    },
)
def predict_state(state, u):
    """Return the state (6,) one step later, for the input u (2,), by MODEL.predict."""
    return np.append(MODEL.predict(state[:3], state[3:], u), state[:3])


def state_input_theta(rng):
    state, u = state_and_input(rng)
    return state, u, (MODEL.theta + OFFSETS) * rng.uniform(0.8, 0.99, (3, 5))


def built(state, u, theta, sign=1.0, rest=True, both=True, swap=False):
    J = np.zeros((6, 6))
    J[:3, :3], J[:3, 3:] = np.diag(theta[:, 0]), np.diag(theta[:, 1])
    v = theta[:2, 2:4] @ u + theta[:2, 4] * rest
    c, s = np.cos(state[2]), np.sin(state[2])
    J[:2, 2] = sign * np.array((-v[0] * s, v[1] * c)) if not swap else (v[0] * c, v[1] * s)
    if both:
        J[3:, :3] = np.eye(3)
    return J


def without_heading(state, u, theta):
    J = built(state, u, theta)
    J[:2, 2] = 0
    return J


@exercise(
    cases=state_input_theta,
    tolerance=2e-5,
    hint="Four blocks of (3, 3). Two are diagonal, one is zero; where does the heading come in?",
    mistakes={
        "x and y depend on the heading, too: the column of the heading is missing.": (
            without_heading
        ),
        "The derivative of the cosine is minus the sine.": (
            lambda state, u, theta: built(state, u, theta, sign=np.array((-1, 1)))
        ),
        "These are cosine and sine themselves, not their derivatives.": (
            lambda state, u, theta: built(state, u, theta, swap=True)
        ),
        "The last three rows say that the pose becomes the pose before: an identity.": (
            lambda state, u, theta: built(state, u, theta, both=False)
        ),
        "The next previous pose is this pose: its identity stands in the first three columns.": (
            lambda state, u, theta: (
                built(state, u, theta, both=False) + np.pad(np.eye(3), ((3, 0), (3, 0)))
            )
        ),
        "The matrix is transposed: row = next state, column = this state.": (
            lambda state, u, theta: built(state, u, theta).T
        ),
        "This has the parameters of MODEL: use the argument theta.": (
            lambda state, u, theta: built(state, u, MODEL.theta)
        ),
        "The speed v has d1, too.": lambda state, u, theta: built(state, u, theta, rest=False),
    },
)
def jacobian_of(state, u, theta):
    """Return the Jacobian (6, 6) of predict_state."""
    J = np.zeros((6, 6))
    J[:3, :3], J[:3, 3:], J[3:, :3] = np.diag(theta[:, 0]), np.diag(theta[:, 1]), np.eye(3)
    v = theta[:, 2:4] @ u + theta[:, 4]
    J[0, 2] = -v[0] * np.sin(state[2])
    J[1, 2] = v[1] * np.cos(state[2])
    return J


def covariance(rng, n):
    root = rng.normal(size=(n, n))
    return root @ root.T + np.eye(n)


def to_predict(rng):
    state, u, theta = state_input_theta(rng)
    return state, covariance(rng, 6), u, covariance(rng, 3), theta


def predicted(state, P, u, Q, theta, at=None, place=slice(3)):
    F = jacobian_of(state if at is None else at, u, theta)
    P = F @ P @ F.T
    P[place, place] += Q
    return predict_state(state, u), P


@exercise(
    cases=to_predict,
    tolerance=1e-7,
    hint="Compute F before you change the state. Which part of P belongs to the new pose?",
    mistakes={
        "Q is missing: the robot slips.": lambda state, P, u, Q, theta: predicted(
            state, P, u, 0 * Q, theta
        ),
        "The Jacobian has the parameters of MODEL: give it the argument theta.": (
            lambda state, P, u, Q, theta: predicted(state, P, u, Q, MODEL.theta)
        ),
        "Q belongs to the new pose, the first three numbers of the state.": (
            lambda *given: predicted(*given, place=slice(3, 6))
        ),
        "The state moves by predict_state, not by the Jacobian.": (
            lambda state, P, u, Q, theta: (
                jacobian_of(state, u, theta) @ state,
                predicted(state, P, u, Q, theta)[1],
            )
        ),
        "Only the new pose gets new noise, not the old one.": lambda state, P, u, Q, theta: (
            predict_state(state, u),
            predicted(state, P, u, Q, theta)[1] + np.pad(Q, ((3, 0), (3, 0))),
        ),
        "The Jacobian belongs to the old state: compute it before you predict.": (
            lambda state, P, u, Q, theta: predicted(
                state, P, u, Q, theta, at=predict_state(state, u)
            )
        ),
        "F stands on both sides of P: F P F', the second one transposed.": (
            lambda state, P, u, Q, theta: (
                predict_state(state, u),
                jacobian_of(state, u, theta) @ P + np.pad(Q, ((0, 3), (0, 3))),
            )
        ),
        "The transposed one comes last: F P F', not F' P F.": (
            lambda state, P, u, Q, theta: (
                predict_state(state, u),
                jacobian_of(state, u, theta).T @ P @ jacobian_of(state, u, theta)
                + np.pad(Q, ((0, 3), (0, 3))),
            )
        ),
    },
)
def ekf_predict(state, P, u, Q, theta):
    """Return the predicted state (6,) and covariance (6, 6)."""
    F = jacobian_of(state, u, theta)
    P = F @ P @ F.T
    P[:3, :3] += Q
    return predict_state(state, u), P


@exercise(
    cases=lambda rng: (rng.normal(size=3), covariance(rng, 3)),
    hint="e has three numbers, S^-1 nine. Which products make one number of e, S^-1 and e?",
    mistakes={
        "S^-1, not S: a larger covariance makes the distance smaller.": lambda e, S: e @ S @ e,
        "This is the distance: return its square.": lambda e, S: np.sqrt(e @ np.linalg.solve(S, e)),
        "The correlations count, too: this has the diagonal of S alone.": lambda e, S: (
            e**2 / np.diag(S)
        ).sum(),
        "1 / S inverts each number: np.linalg.inv(S) inverts the matrix.": (
            lambda e, S: e @ (1 / S) @ e
        ),
        "The covariance is missing in it.": lambda e, S: e @ e,
        "This is half of it.": lambda e, S: 0.5 * e @ np.linalg.solve(S, e),
    },
)
def squared_distance(e, S):
    """Return the squared distance of an innovation e (3,) with the covariance S (3, 3)."""
    return e @ np.linalg.solve(S, e)
