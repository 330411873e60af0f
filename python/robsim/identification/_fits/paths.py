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
    """
    from scipy.signal import lfilter

    # s / force = 1 / (1 - a1 z - a2 z^2), with the delay z
    filtered: Floats = lfilter([1.0], [1.0, -a1, -a2], force, axis=0)
    return filtered
