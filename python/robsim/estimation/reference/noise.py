"""The filters' noises: default standard deviations, checks of a user's own, roots."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robsim.base.checks import Floats, check_float
from robsim.base.text import quoted

#: Of a pose measured from frames of 1200 px with 36 drawn headings: px, px, rad. Measured: 0.28,
#: 0.28, 0.050.
MEASUREMENT_SIGMA = (0.3, 0.3, 0.05)

#: Of the process noise of the pose in each step: px, px, rad. With it the filters are consistent
#: in a world with ``process_noise=PoseNoise.from_sigma(0.1, 0.1, 0.005)``, and conservative in one
#: without disturbances, where 0 is right.
PROCESS_SIGMA = (0.1, 0.1, 0.005)


def check_vector3(
    name: str,
    values: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return checked numbers for x, y and the heading, an array (3,)."""
    try:
        entries = [*values]
    except TypeError:
        entries = []
    if len(entries) != 3:
        raise ValueError(
            f"{name} must be 3 numbers, for x, y and the heading, got {quoted(values)}"
        )
    return np.array(
        [
            check_float(name, entry, minimum=minimum, exclusive_minimum=exclusive_minimum)
            for entry in entries
        ]
    )


def check_process_sigma(sigma: Sequence[float]) -> Floats:
    """Return the checked option ``process_sigma``, an array (3,)."""
    if isinstance(sigma, (tuple, list)) and len(sigma) == 2:
        raise ValueError(
            f"process_sigma must be 3 numbers, for x, y and the heading, "
            f"got {quoted(sigma)}: those of "
            "a WheelNoise are in V; noise.Q(model, heading) is the covariance of the pose that it "
            "causes"
        )
    return check_vector3("process_sigma", sigma, minimum=0)


def covariance(
    name: str,
    sigma: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return the covariance (3, 3) of independent noises of these standard deviations."""
    return np.diag(
        check_vector3(name, sigma, minimum=minimum, exclusive_minimum=exclusive_minimum) ** 2
    )


def root(P: Floats) -> Floats:
    """Return L with L L' = P, the same on every processor.

    Eigenvectors alone are not: for equal eigenvalues any basis is valid, and linear-algebra
    kernels differ in the one they return.
    """
    try:
        return np.asarray(np.linalg.cholesky(P), dtype=np.float64)
    except np.linalg.LinAlgError:  # P is singular but for rounding, as without process noise
        # P^(1/2) = V sqrt(D) V' is unique, whatever V is
        eigenvalues, V = np.linalg.eigh(P)
        return np.asarray((V * np.sqrt(np.maximum(eigenvalues, 0))) @ V.T, dtype=np.float64)
