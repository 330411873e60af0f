"""Linear least squares and blockwise QR, for the iterative fits."""

from __future__ import annotations

import numpy as np

from robsim._base.checks import Floats

# Singular values below this fraction of the maximum, for columns of length 1, are rounding errors.
_ROUNDING = 1e-9
_BLOCK = 128


def solve(matrix: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Solve matrix x = right by least squares.

    Parameters
    ----------
    matrix : array (N, n)
        One column per unknown.
    right : array (N,)
        Right-hand side.

    Returns
    -------
    x : array (n,)
        The minimum-norm solution, for columns scaled to length 1.
    covariance : array (n, n)
        (matrix' matrix)^-1; NaN on the diagonal for unknowns that the rows do not determine.
    """
    length = np.linalg.norm(matrix, axis=0)
    length[length == 0] = 1
    left, values, directions = np.linalg.svd(matrix / length, full_matrices=False)
    is_nonzero = values > _ROUNDING * values.max(initial=0.0)
    inverse = directions[is_nonzero].T / values[is_nonzero]
    covariance = inverse @ inverse.T
    # An unknown with a component in the null space is not determined.
    null_fraction = 1 - np.square(directions[is_nonzero]).sum(axis=0)
    is_undetermined = null_fraction > 1e-6
    covariance[is_undetermined, is_undetermined] = np.nan
    x = inverse @ (left[:, is_nonzero].T @ right)
    return x / length, covariance / np.outer(length, length)


def triangle(matrix: Floats) -> Floats:
    """Return the triangular factor R of matrix = Q R, or of each of a stack of matrices.

    Many rows are factored block by block: R follows from the blocks' factors alone, and small
    blocks keep the linear algebra in one thread, which is faster.
    """
    while matrix.ndim == 2 and len(matrix) > 2 * _BLOCK:
        blocks = -(-len(matrix) // _BLOCK)
        padded = np.zeros((blocks * _BLOCK, matrix.shape[1]))
        padded[: len(matrix)] = matrix
        factors = np.linalg.qr(padded.reshape(blocks, _BLOCK, -1), mode="r")
        matrix = np.vstack(list(factors))
    return np.asarray(np.linalg.qr(matrix, mode="r"), dtype=np.float64)
