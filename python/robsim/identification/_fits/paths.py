"""Simulated paths of the robot model and their sensitivities, which the fits are built on."""

from __future__ import annotations

import numpy as np

from robsim._base.checks import Floats

X, Y, HEADING = 0, 1, 2
FIRST = 6
"""Number of unknown initial values of a segment: x, y and heading of its first two steps."""
UNKNOWNS = FIRST + 15


def recursion(a1: float, a2: float, force: Floats) -> Floats:
    """Return s(k) = a1 s(k-1) + a2 s(k-2) + force(k), column by column; s = 0 before the first.

    Parameters
    ----------
    a1, a2 : float
        The parameters.
    force : array (n,) or (n, m)
        The driving term.

    Notes
    -----
    Computed in log2(n) passes over whole arrays, by Graeffe's root squaring of the delay
    polynomial: 1/A(z) = A(-z) / (A(z) A(-z)), whose denominator has only even powers of the delay
    z.
    """
    result = force
    lag = 1
    while lag < len(force):
        # A(-z) = 1 + a1 z - a2 z^2
        filtered = result.copy()
        filtered[lag:] += a1 * result[:-lag]
        filtered[2 * lag :] -= a2 * result[: -2 * lag]
        # A(z) A(-z) = 1 - (a1^2 + 2 a2) z^2 + a2^2 z^4
        a1, a2 = a1 * a1 + 2 * a2, -a2 * a2
        result = filtered
        lag *= 2
    return result


def simulated_path(theta: Floats, first: Floats, u: Floats) -> Floats:
    """Return the path (n, 3) of the robot model.

    Parameters
    ----------
    theta : array (3, 5)
        Rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
    first : array (2, 3)
        The first two poses.
    u : array (n, 2)
        Inputs (V).
    """
    path = np.empty((len(u), 3))
    path[:, HEADING] = axis_path(theta[HEADING], first[:, HEADING], u, np.ones(len(u)))
    path[:, X] = axis_path(theta[X], first[:, X], u, np.cos(path[:, HEADING]))
    path[:, Y] = axis_path(theta[Y], first[:, Y], u, np.sin(path[:, HEADING]))
    return path


def axis_path(theta: Floats, first: Floats, u: Floats, direction: Floats) -> Floats:
    """Return the path (n,) of one axis, whose direction is cos or sin of the heading, or 1."""
    a1, a2, b1, b2, d1 = theta
    force = np.empty(len(u))
    # x(k) = a1 x(k-1) + a2 x(k-2) + (b1 u1(k-1) + b2 u2(k-1) + d1) direction(k-1)
    force[2:] = ((u @ (b1, b2) + d1) * direction)[1:-1]
    force[:2] = first[0], first[1] - a1 * first[0]
    return recursion(a1, a2, force)


def sensitivities(theta: Floats, path: Floats, u: Floats) -> Floats:
    """Return the derivatives (n, 3, 21) of a simulated path.

    Parameters
    ----------
    theta : array (3, 5)
        The parameters.
    path : array (n, 3)
        The path simulated with them.
    u : array (n, 2)
        Inputs (V).

    Returns
    -------
    array (n, 3, 21)
        Derivatives by the first two values of x, of y and of the heading, and by the 15 parameters.
    """
    heading = path[:, HEADING]
    cos, sin = np.cos(heading), np.sin(heading)
    result = np.zeros((len(u), 3, UNKNOWNS))
    own = [
        [2 * axis, 2 * axis + 1, *range(FIRST + 5 * axis, FIRST + 5 * axis + 5)]
        for axis in range(3)
    ]
    turn = _own_forces(theta[HEADING], heading, u, np.ones(len(u)))
    turn = recursion(theta[HEADING, 0], theta[HEADING, 1], turn)
    result[:, HEADING, own[HEADING]] = turn
    for axis, direction, slope in ((X, cos, -sin), (Y, sin, cos)):
        a1, a2, b1, b2, d1 = theta[axis]
        # The force depends on the heading: d force/d heading = (b1 u1 + b2 u2 + d1) slope
        by_heading = np.zeros_like(turn)
        by_heading[2:] = (((u @ (b1, b2) + d1) * slope)[:, None] * turn)[1:-1]
        forces = np.hstack([_own_forces(theta[axis], path[:, axis], u, direction), by_heading])
        result[:, axis, np.hstack([own[axis], own[HEADING]])] = recursion(a1, a2, forces)
    return result


def _own_forces(theta: Floats, path: Floats, u: Floats, direction: Floats) -> Floats:
    """Return the driving terms of an axis's derivatives by its first two values and parameters."""
    forces = np.zeros((len(u), 7))
    forces[0, 0], forces[1, 0], forces[1, 1] = 1, -theta[0], 1
    forces[2:, 2] = path[1:-1]
    forces[2:, 3] = path[:-2]
    forces[2:, 4:6] = (u * direction[:, None])[1:-1]
    forces[2:, 6] = direction[1:-1]
    return forces
