"""How large the noises are."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robsim._base.checks import Floats, check_float

#: Of the vision of a robot shown in 36 headings: px, px, rad.
MEASUREMENT_NOISE = (0.4, 0.4, 0.05)

#: What the robot model does not say of the next pose: px, px, rad.
PROCESS_NOISE = (0.1, 0.1, 0.005)


def check_vector3(
    name: str,
    values: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return a number for each of x, y and the heading; the error names what they are not."""
    try:
        entries = [*values]
    except TypeError:
        entries = []
    if len(entries) != 3:
        raise ValueError(f"{name} must be 3 numbers, for x, y and the heading, got {values!r}")
    return np.array(
        [
            check_float(name, entry, minimum=minimum, exclusive_minimum=exclusive_minimum)
            for entry in entries
        ]
    )


def covariance(
    name: str,
    deviations: Sequence[float],
    *,
    minimum: float = -math.inf,
    exclusive_minimum: float = -math.inf,
) -> Floats:
    """Return the covariance of three independent noises of these standard deviations."""
    return np.diag(
        check_vector3(name, deviations, minimum=minimum, exclusive_minimum=exclusive_minimum) ** 2
    )
