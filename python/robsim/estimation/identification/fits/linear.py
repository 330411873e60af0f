"""Linear least squares, blockwise QR and first estimates, for the iterative fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import rank_tolerance, regression, second_order_recursion
from robsim.base.checks import Floats
from robsim.estimation.identification.fits.segments import Segment
from robsim.estimation.identification.fits.unknowns import HEADING, X, Y

_BLOCK = 128


def solve(matrix: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Solve matrix (N, n) x = right (N,) or (N, m) by least squares; return x and its covariance.

    x is the minimum-norm solution, for columns scaled to length 1; the covariance (n, n) is
    (matrix' matrix)^-1, NaN on the diagonal for unknowns that the rows do not determine.
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


# One pole of each axis is 1; these are the candidates for the other one, from fast to slow.
_POLES = 1 - np.geomspace(1.0, 0.01, 14)


def initial_estimate(segments: list[Segment]) -> Floats:
    """Return theta (3, 5): for each axis the best candidate pole, with b1, b2 and d1 fitted to it.

    It needs no start, has no bias from noise, and interpolates headings in the (short) gaps.
    """
    best = _POLES[np.argmin(costs_of_poles(segments), axis=0)]
    return np.array([axis_with_pole(segments, axis, best[axis]) for axis in (X, Y, HEADING)])


def costs_of_poles(segments: list[Segment]) -> Floats:
    """Return the sums of squared residuals (n, 3) for each of the candidate poles and each axis."""
    parts = []
    for segment in segments:
        forces = _forces(segment)
        columns = np.empty((len(_POLES), *forces[segment.seen].shape[:2], 6))
        columns[..., 5] = segment.poses[segment.seen]
        for responses, pole in zip(columns, _POLES, strict=True):
            path = second_order_recursion(1 + pole, -pole, forces.reshape(len(forces), -1))
            responses[..., :5] = path.reshape(forces.shape)[segment.seen]
        parts.append(triangle(np.swapaxes(columns, 1, 2))[..., 2:, 2:])
    # The last element on the diagonal is the norm of the last column less its fit by the others.
    return np.asarray(np.square(triangle(np.concatenate(parts, axis=-2))[..., -1, -1]))


def axis_with_pole(segments: list[Segment], axis: int, pole: float) -> Floats:
    """Return the best (5,) of an axis with poles 1 and `pole`.

    For given poles the path is linear in b1, b2, d1 and the first two values of each segment.
    """
    a1, a2 = 1 + pole, -pole
    parts = []
    for segment in segments:
        responses = second_order_recursion(a1, a2, _forces(segment)[:, axis])[segment.seen]
        columns = np.column_stack([responses, segment.poses[segment.seen, axis]])
        parts.append(triangle(columns)[2:, 2:])
    columns = np.vstack(parts)
    gains, _ = solve(columns[:, :3], columns[:, 3])
    return np.hstack([a1, a2, gains])


def _forces(segment: Segment) -> Floats:
    """Return the excitations of the axes (n, 3, 5): their first two values, then b1, b2 and d1."""
    phi, _ = regression(segment.interpolated(), segment.u)
    forces = np.zeros((len(segment.u), 3, 5))
    forces[0, :, 0] = forces[1, :, 1] = 1
    forces[2:, :, 2:] = phi[:, :, 2:]
    return forces


@dataclass(frozen=True, eq=False)
class Decomposition:
    """matrix = U diag(s) V' diag(lengths), without the singular values that are rounding errors."""

    lengths: Floats  # (..., n): lengths of the columns; 1 for a column of zeros
    U: Floats  # (..., N, m): left singular vectors of the columns scaled to length 1
    inverse: Floats  # (..., n, m): V s^-1; 0 for a rounding error
    is_determined: NDArray[np.bool_]  # (..., n): the unknowns without a component in the null space


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
