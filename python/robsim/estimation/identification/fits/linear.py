"""Linear least squares and blockwise QR, for the iterative fits."""

from __future__ import annotations

import numpy as np

from robsim.base.checks import Floats, decompose

_BLOCK = 128


def solve(matrix: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Solve matrix x = right by least squares.

    Parameters
    ----------
    matrix : array (N, n)
        One column per unknown.
    right : array (N,) or (N, m)
        Right-hand side, or m of them.

    Returns
    -------
    x : array (n,) or (n, m)
        The minimum-norm solution, for columns scaled to length 1.
    covariance : array (n, n)
        (matrix' matrix)^-1; NaN on the diagonal for unknowns that the rows do not determine.
    """
    parts = decompose(matrix)
    # x = V s^-1 U' right,  (matrix' matrix)^-1 = V s^-2 V'
    x = parts.inverse @ (parts.U.T @ right)
    covariance = parts.inverse @ parts.inverse.T
    is_undetermined = ~parts.is_determined
    covariance[is_undetermined, is_undetermined] = np.nan
    return (x.T / parts.lengths).T, covariance / np.outer(parts.lengths, parts.lengths)


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
