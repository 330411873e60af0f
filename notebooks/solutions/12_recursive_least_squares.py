"""The answers of the notebook 12_recursive_least_squares, and mistakes that students make."""

import math

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


def two_poses(rng):
    """Return poses on both sides of the negative x axis, in every second case; in both turns."""
    x, y = rng.uniform(100, 900, 2)
    turn = rng.choice((-1, 1))
    heading = turn * (math.pi - 0.05) if rng.integers(2) else rng.uniform(-1.5, 1.5)
    pose_1 = x + 3, y - 2, robsim.wrap_angle(heading + turn * rng.uniform(0.1, 0.2))
    return np.array(pose_1), np.array((x, y, heading)), rng.uniform(-1, 1, 2)


def rows(pose_1, pose_2, u, older, factors):
    x, y, heading = pose_1
    pairs = (x, pose_2[0]), (y, pose_2[1]), (heading, older)
    return [
        (*pair, u[0] * factor, u[1] * factor, factor)
        for pair, factor in zip(pairs, factors, strict=True)
    ]


def unwrapped(pose_1, pose_2):
    return pose_1[2] - robsim.wrap_angle(pose_1[2] - pose_2[2])


def factors_at(heading):
    return math.cos(heading), math.sin(heading), 1.0


@exercise(
    cases=two_poses,
    hint="Write the row of X first. Y differs from it by one function, P by having none.",
    mistakes={
        "The older heading jumps where the robot crosses the negative x axis: unwrap it.": (
            lambda p1, p2, u: rows(p1, p2, u, p2[2], factors_at(p1[2]))
        ),
        "pose_1 is the newer one: it comes first in each row.": lambda p1, p2, u: [
            (row[1], row[0], *row[2:])
            for row in rows(p1, p2, u, unwrapped(p1, p2), factors_at(p1[2]))
        ],
        "Keep the newer heading, and move the older one.": lambda p1, p2, u: rows(
            (*p1[:2], p2[2] + robsim.wrap_angle(p1[2] - p2[2])), p2, u, p2[2], factors_at(p1[2])
        ),
        "Cosine belongs to x, sine to y.": lambda p1, p2, u: rows(
            p1, p2, u, unwrapped(p1, p2), (math.sin(p1[2]), math.cos(p1[2]), 1.0)
        ),
        "The factor has the heading of step k - 1, not of step k - 2.": (
            lambda p1, p2, u: rows(p1, p2, u, unwrapped(p1, p2), factors_at(p2[2]))
        ),
        "The heading itself has no cosine or sine: its factor is 1.": lambda p1, p2, u: rows(
            p1, p2, u, unwrapped(p1, p2), (math.cos(p1[2]), math.sin(p1[2]), math.cos(p1[2]))
        ),
        "The last column is the factor of the inputs, not 1.": lambda p1, p2, u: [
            (*row[:4], 1.0) for row in rows(p1, p2, u, unwrapped(p1, p2), factors_at(p1[2]))
        ],
        "The inputs of the axes X and Y lack their factor.": lambda p1, p2, u: [
            (*row[:2], *u, row[4]) for row in rows(p1, p2, u, unwrapped(p1, p2), factors_at(p1[2]))
        ],
    },
)
def regressor(pose_1, pose_2, u):
    """Return the regressors of the axes X, Y, P, of shape (3, 5)."""
    (x_1, y_1, heading_1), (x_2, y_2, heading_2) = pose_1, pose_2
    heading_2 = heading_1 - robsim.wrap_angle(heading_1 - heading_2)
    c, s = np.cos(heading_1), np.sin(heading_1)
    return np.array(
        [
            (x_1, x_2, u[0] * c, u[1] * c, c),
            (y_1, y_2, u[0] * s, u[1] * s, s),
            (heading_1, heading_2, u[0], u[1], 1),
        ]
    )


def covariance(rng):
    root = rng.normal(size=(4, 4))
    return root @ root.T + np.eye(4)


def one_sample(rng):
    return covariance(rng), rng.normal(size=4), rng.uniform(0.9, 0.99)


@exercise(
    cases=one_sample,
    hint="The numerator is a vector, the denominator a number. In numpy, @ is the product of both.",
    mistakes={
        "The denominator lacks the forgetting factor.": (
            lambda P, phi, forgetting: P @ phi / (phi @ P @ phi)
        ),
        "The denominator has the forgetting factor, not 1.": (
            lambda P, phi, forgetting: P @ phi / (1 + phi @ P @ phi)
        ),
        "The denominator has phi' P phi, with P in the middle.": (
            lambda P, phi, forgetting: P @ phi / (forgetting + phi @ phi)
        ),
        "P * phi is a matrix: P @ phi is the vector that you need.": (
            lambda P, phi, forgetting: P * phi / (forgetting + phi @ P @ phi)
        ),
        "The numerator is P phi, not phi alone.": (
            lambda P, phi, forgetting: phi / (forgetting + phi @ P @ phi)
        ),
    },
)
def gain(P, phi, forgetting):
    """Return the gain K (n,), from the covariance P (n, n) and a regressor phi (n,)."""
    return P @ phi / (forgetting + phi @ P @ phi)


def filter_and_sample(rng):
    P, phi, forgetting = one_sample(rng)
    return rng.normal(size=4), P, phi, rng.normal(), forgetting


def updated(theta, P, phi, y, forgetting, *, sign=1, divisor=None, used=None):
    K = gain.right(P, phi, forgetting)
    new = (P - np.outer(K, phi) @ P) / (forgetting if divisor is None else divisor)
    K = K if used is None else gain.right(used(new), phi, forgetting)
    return theta + sign * K * (y - phi @ theta), new


@exercise(
    cases=filter_and_sample,
    hint="K times phi' is a matrix: np.outer. Compare each of your terms with the two formulas.",
    mistakes={
        "The covariance is not divided by the forgetting factor.": (
            lambda *given: updated(*given, divisor=1)
        ),
        "The estimate moves the wrong way: the error is y minus the prediction.": (
            lambda *given: updated(*given, sign=-1)
        ),
        "The gain belongs to the old P: compute it before you change P.": (
            lambda *given: updated(*given, used=lambda new: new)
        ),
        "K * phi is a vector: the product K phi' is np.outer(K, phi).": (
            lambda theta, P, phi, y, forgetting: (
                updated(theta, P, phi, y, forgetting)[0],
                (P - gain.right(P, phi, forgetting) * phi @ P) / forgetting,
            )
        ),
        "P does not change: then every sample counts as much as the first.": (
            lambda theta, P, phi, y, forgetting: (updated(theta, P, phi, y, forgetting)[0], P)
        ),
        "The covariance is multiplied by the forgetting factor: divide it by the factor instead.": (
            lambda theta, P, phi, y, forgetting: updated(
                theta, P, phi, y, forgetting, divisor=1 / forgetting
            )
        ),
    },
)
def rls_update(theta, P, phi, y, forgetting):
    """Return the new estimate (n,) and its covariance (n, n)."""
    K = gain(P, phi, forgetting)
    return theta + K * (y - phi @ theta), (P - np.outer(K, phi) @ P) / forgetting
