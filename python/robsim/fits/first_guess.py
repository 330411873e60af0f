"""A first guess of the parameters."""

from __future__ import annotations

import numpy as np

from robsim.fits.linear import solve, triangle
from robsim.fits.paths import HEADING, X, Y, recursion
from robsim.fits.stretches import Stretch
from robsim.numbers import Floats

# One pole of each axis is 1; the other one is tried from quick to slow.
_POLES = 1 - np.geomspace(1.0, 0.01, 14)


def first_guess(stretches: list[Stretch]) -> Floats:
    """Return theta (3, 5): for each axis the best of some poles, and the forces that fit it.

    With the poles given the path is linear in b1, b2, d1 and the first two values of each stretch.
    Nothing has to be started, and noise in the poses does not bias it.

    Parameters
    ----------
    stretches : list of Stretch
        With short gaps at most: headings are interpolated.
    """
    headings = [stretch.interpolated()[:, HEADING] for stretch in stretches]
    directions = {
        X: [np.cos(heading) for heading in headings],
        Y: [np.sin(heading) for heading in headings],
        HEADING: [np.ones(len(heading)) for heading in headings],
    }
    return np.array([_best_axis(stretches, axis, directions[axis]) for axis in (X, Y, HEADING)])


def _best_axis(stretches: list[Stretch], axis: int, directions: list[Floats]) -> Floats:
    guesses = [_axis_with_pole(stretches, axis, directions, float(pole)) for pole in _POLES]
    return min(guesses, key=lambda guess: guess[1])[0]


def _axis_with_pole(
    stretches: list[Stretch], axis: int, directions: list[Floats], pole: float
) -> tuple[Floats, float]:
    """Return the parameters (5,) of an axis, and the sum of squares that they leave over."""
    a1, a2 = 1 + pole, -pole
    parts = []
    for stretch, direction in zip(stretches, directions, strict=True):
        forces = np.zeros((len(direction), 5))
        forces[0, 0] = forces[1, 1] = 1
        forces[2:, 2:4] = (stretch.u * direction[:, None])[1:-1]
        forces[2:, 4] = direction[1:-1]
        responses = recursion(a1, a2, forces)[stretch.seen]
        columns = np.column_stack([responses, stretch.poses[stretch.seen, axis]])
        parts.append(triangle(columns)[2:, 2:])
    columns = np.vstack(parts)
    gains, _ = solve(columns[:, :3], columns[:, 3])
    left = columns[:, 3] - columns[:, :3] @ gains
    return np.hstack([a1, a2, gains]), float(np.square(left).sum())
