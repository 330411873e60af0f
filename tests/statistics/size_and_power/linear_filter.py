"""A Kalman filter of position and velocity, many trials at once, right or with a wrong Q or R."""

from __future__ import annotations

import numpy as np

DT = 0.2
F = np.array([[1.0, DT], [0.0, 1.0]])
Q = np.array([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]])
H = np.array([[1.0, 0.0]])
R = np.array([[1.0]])
P0 = np.eye(2)


def filtered(trials, steps, *, q=1.0, r=1.0, rng):
    """Errors (trials, steps, 2), P, innovations, S of a Kalman filter that assumes q Q and r R."""
    x = rng.normal(size=(trials, 2)) @ np.linalg.cholesky(P0).T
    process_noise = rng.normal(size=(steps, trials, 2)) @ np.linalg.cholesky(Q).T
    estimate, P = np.zeros((trials, 2)), P0
    errors, innovations = np.empty((trials, steps, 2)), np.empty((trials, steps, 1))
    covariances, S = np.empty((steps, 2, 2)), np.empty((steps, 1, 1))
    for k in range(steps):
        if k > 0:
            x = x @ F.T + process_noise[k]
            estimate, P = estimate @ F.T, F @ P @ F.T + q * Q
        innovations[:, k] = x @ H.T + rng.normal(size=(trials, 1)) - estimate @ H.T
        S[k] = H @ P @ H.T + r * R
        K = P @ H.T / S[k]
        estimate, P = estimate + innovations[:, k] @ K.T, (np.eye(2) - K @ H) @ P
        errors[:, k], covariances[k] = estimate - x, P
    return errors, covariances, innovations, S


def factors(q, r):
    """What is wrong with Q and R, in words."""
    parts = [f"{name} x {factor:g}" for name, factor in (("Q", q), ("R", r)) if factor != 1]
    return ", ".join(parts) or "right"


def key_of(case, answer):
    """The key of an answer in a case: length of the record, factors of Q and R."""
    return " ".join(f"{number:g}" for number in case) + f" {answer}"
