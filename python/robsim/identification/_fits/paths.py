"""The order of the unknowns of a fit, and the filter 1/A of an axis."""

from __future__ import annotations

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
