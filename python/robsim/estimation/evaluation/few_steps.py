"""The few steps that make an error, and their reasons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats

Bools = NDArray[np.bool_]

# Of normal errors 12 % of the steps make half of the sum of squares, of clean frames often 5 %.
_FEW = 0.03
_MOST = 0.1  # of all steps
_LEAST_KNOWN = 60  # steps: of fewer, two or three large errors are chance
_AFTER = 5  # steps
_FIRST = 10  # steps of a run
_MOST_NUMBERS = 5


def few_steps(error: Floats) -> Bools:
    """Return the steps (M, N, n) of each component that stand out of its error.

    These are the fewest that make half of the sum of squares, then half of the rest, and so on.
    Each half takes at most 3 % of the steps, all halves together 10 %.
    """
    few = np.zeros(error.shape, dtype=bool)
    for i in range(error.shape[-1]):
        squares = np.square(error[..., i]).ravel()
        largest = np.argsort(-squares)[: np.count_nonzero(~np.isnan(squares))]
        few[..., i].flat[largest[: _count(squares[largest])]] = True
    return few


def _count(squares: Floats) -> int:
    """Return how many of some squares (n,), the largest first, stand out."""
    if len(squares) < _LEAST_KNOWN:
        return 0
    rest = np.append(np.cumsum(squares[::-1])[::-1], 0.0)  # the sum from each one on
    count = 0
    while rest[count] > 0:
        halved = int(np.argmax(rest <= rest[count] / 2))
        if halved - count > _FEW * len(squares) or halved > _MOST * len(squares):
            break
        count = halved
    return count


def reasons(few: Bools, seen: Bools, bounced: Bools, k: NDArray[np.int64]) -> list[str]:
    """Return the number of steps (M, N) for each reason; others by their numbers `k` (N,)."""
    ways = {
        "before the robot was first seen": ~np.logical_or.accumulate(seen, axis=1),
        "while it was not seen": ~seen,
        f"within {_AFTER} steps after a bounce": _recent(bounced),
        f"within {_AFTER} steps after a gap": _recent(~seen),
        f"in the first {_FIRST} steps": np.broadcast_to(k < _FIRST, few.shape),
    }
    texts, rest = [], few.copy()
    for way, steps in ways.items():
        if count := np.count_nonzero(rest & steps):
            texts.append(f"{count} {way}")
        rest &= ~steps
    numbers = [str(number) for number in np.unique(k[np.nonzero(rest)[1]])]
    if numbers:
        shown = ", ".join(numbers[:_MOST_NUMBERS]) + ", ..." * (len(numbers) > _MOST_NUMBERS)
        texts.append(f"{np.count_nonzero(rest)} at step {shown}")
    return texts


def _recent(events: Bools) -> Bools:
    recent = events.copy()
    for late in range(1, _AFTER + 1):
        recent[:, late:] |= events[:, :-late]
    return recent
