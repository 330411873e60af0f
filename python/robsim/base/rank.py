"""What full rank is, for a matrix of regressors or derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import rank_tolerance
from robsim.base.checks import Floats


@dataclass(frozen=True, eq=False)
class Decomposition:
    """matrix = U diag(s) V' diag(lengths), without the singular values that are rounding errors.

    Attributes
    ----------
    lengths : array (..., n)
        Lengths of the columns; 1 for a column of zeros.
    U : array (..., N, m)
        Left singular vectors of the columns scaled to length 1.
    inverse : array (..., n, m)
        V s^-1; 0 for a rounding error.
    is_determined : array (..., n) of bool
        The unknowns without a component in the null space.
    """

    lengths: Floats
    U: Floats
    inverse: Floats
    is_determined: NDArray[np.bool_]


def decompose(matrix: Floats) -> Decomposition:
    """Return the singular value decomposition of a matrix (..., N, n), by the rule of the core."""
    lengths = np.sqrt(np.sum(np.square(matrix), axis=-2))
    lengths = np.where(lengths > 0, lengths, 1.0)
    U, s, V_transposed = np.linalg.svd(matrix / lengths[..., np.newaxis, :], full_matrices=False)
    is_nonzero = s > rank_tolerance * s.max(axis=-1, initial=0.0, keepdims=True)
    V = np.swapaxes(V_transposed, -1, -2) * is_nonzero[..., np.newaxis, :]
    null_fraction = 1 - np.square(V).sum(axis=-1)
    inverse = V / np.where(is_nonzero, s, 1.0)[..., np.newaxis, :]
    return Decomposition(lengths, U, inverse, np.asarray(null_fraction <= rank_tolerance))
