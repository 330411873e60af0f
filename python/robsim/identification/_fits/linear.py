"""Linear least squares."""

from __future__ import annotations

import numpy as np

from robsim._base.checks import Floats

# Singular values below this share of the largest, of columns of length 1, are rounding.
_ROUNDING = 1e-9
_BLOCK = 128


def solve(matrix: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Solve matrix x = right by least squares.

    Parameters
    ----------
    matrix : array (N, n)
        One column for each unknown.
    right : array (N,)
        Right-hand side.

    Returns
    -------
    x : array (n,)
        The shortest solution, in columns of length 1.
    covariance : array (n, n)
        (matrix' matrix)^-1; NaN on the diagonal of what the rows do not determine.
    """
    length = np.linalg.norm(matrix, axis=0)
    length[length == 0] = 1
    left, values, directions = np.linalg.svd(matrix / length, full_matrices=False)
    there = values > _ROUNDING * values.max(initial=0.0)
    inverse = directions[there].T / values[there]
    covariance = inverse @ inverse.T
    # A parameter that takes part in a direction without effect can be anything.
    open_share = 1 - np.square(directions[there]).sum(axis=0)
    loose = open_share > 1e-6
    covariance[loose, loose] = np.nan
    x = inverse @ (left[:, there].T @ right)
    return x / length, covariance / np.outer(length, length)


def triangle(matrix: Floats) -> Floats:
    """Return the triangular factor R of matrix = Q R, or of each of a stack of matrices.

    Many rows are taken block by block: the rows of the blocks' factors stand for all of them, and
    small blocks keep the linear algebra in one thread, which is faster.
    """
    while matrix.ndim == 2 and len(matrix) > 2 * _BLOCK:
        blocks = -(-len(matrix) // _BLOCK)
        padded = np.zeros((blocks * _BLOCK, matrix.shape[1]))
        padded[: len(matrix)] = matrix
        factors = np.linalg.qr(padded.reshape(blocks, _BLOCK, -1), mode="r")
        matrix = np.vstack(list(factors))
    return np.asarray(np.linalg.qr(matrix, mode="r"), dtype=np.float64)
