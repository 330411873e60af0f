"""A delay of the inputs, in steps that need not be whole: the same in the world, filters, fits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from robsim.base.checks import Floats, check_float

MAXIMUM_DELAY = 1000  # steps


def check_delay(name: str, delay: Any) -> float:
    return check_float(name, delay, "steps", minimum=0, maximum=MAXIMUM_DELAY)


def delayed(u: Floats, delay: float) -> Floats:
    """Return the mean input that acts from each step to the next.

    Parameters
    ----------
    u : array (N, 2)
        The input given at each step (V). Before the first they were 0.
    delay : float
        How late they act (steps).

    Returns
    -------
    array (N, 2)
        In V.
    """
    n = math.floor(delay)
    f = delay - n
    # row k has u(k - n - 1)
    past = np.vstack((np.zeros((n + 1, 2)), u))[: len(u) + 1]
    # u_acting(k) = (1 - f) u(k - n) + f u(k - n - 1), with the delay n + f
    return np.asarray((1 - f) * past[1:] + f * past[:-1])
