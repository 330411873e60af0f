"""The plane that contains groups of points seen by a camera: least squares in the picture.

The points of a group have known positions relative to each other. The first group is in the axes
of the floor; every other group has any position and angle on the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import PlaneMap
from robsim.base.checks import Floats
from robsim.vision.robots.polygons import placed

_LEAST_NOISE = 0.05  # px, the minimum noise of a residual


@dataclass(frozen=True)
class PlaneFit:
    """The fitted plane."""

    to_floor: Floats  # (3, 3): the homography from ideal pixels to the floor (mm)
    places: Floats  # (G, 3): of each group: x, y (mm), angle (rad); 0 of the first
    residuals: list[Floats]  # (N, 2) of each group, in ideal pixels
    parameters: Floats
    jacobian: Floats  # (2 N, P): of the residuals, by the parameters
    view: _Camera

    @property
    def squares(self) -> float:
        """Sum of the squared residuals (px^2)."""
        return float(sum((one**2).sum() for one in self.residuals))

    @property
    def free(self) -> int:
        """How many more numbers there are than parameters."""
        return int(self.jacobian.shape[0] - self.jacobian.shape[1])

    def gains(self) -> Floats:
        """Return by about how much the squares would sink without each point (px^2).

        Of a linear model e' (I - H)^-1 e, with the point's residual e and its block H of the
        projection J (J' J)^-1 J': D. A. Belsley, E. Kuh and R. E. Welsch, Regression Diagnostics,
        Wiley, 1980.
        """
        rows = self.jacobian.reshape(-1, 2, self.jacobian.shape[1])
        inverse = np.linalg.pinv(self.jacobian.T @ self.jacobian)
        errors = np.concatenate(self.residuals)
        left = np.eye(2) - np.einsum("nip,pq,njq->nij", rows, inverse, rows)
        # a point that alone tells a parameter has no residual: left is singular there
        gains: Floats = np.einsum("ni,nij,nj->n", errors, np.linalg.pinv(left, 1e-6), errors)
        return gains

    def expected_errors(self, positions: Floats) -> Floats:
        """Return standard deviations (N,) of the map at positions (N, 2) on the floor (mm)."""
        variance = max(self.squares / max(self.free, 1), _LEAST_NOISE**2)
        covariance = variance * np.linalg.pinv(self.jacobian.T @ self.jacobian)
        pixels = _applied(_inverse(self.to_floor), positions)
        steps = []
        for index, value in enumerate(self.parameters):
            step = 1e-6 * max(abs(value), 1e-2)
            moved = self.parameters.copy()
            moved[index] += step
            to_floor = _inverse(self.view.to_pixels(moved))
            steps.append((_applied(to_floor, pixels) - positions) / step)
        sensitivity = np.stack(steps, axis=-1)  # (N, 2, P)
        spread = np.einsum("nip,pq,niq->n", sensitivity, covariance, sensitivity)
        deviations: Floats = np.sqrt(np.maximum(spread, 0))
        return deviations


class _Camera:
    """The parameters of a homography from the floor to ideal pixels.

    With the matrix of a lens it is K [r1 r2 t]: six parameters, otherwise all eight.
    """

    def __init__(self, matrix: Floats | None, scale: float, centre: Floats) -> None:
        self._matrix = matrix
        # The floor in units of about 1, about the middle of the points.
        self._normal = np.array(
            [(1 / scale, 0, -centre[0] / scale), (0, 1 / scale, -centre[1] / scale), (0, 0, 1.0)]
        )
        self.count = 8 if matrix is None else 6

    def start(self, to_pixels: Floats) -> Floats:
        """Return the parameters of about this homography."""
        from scipy.spatial.transform import Rotation  # scipy loads slowly

        h = to_pixels @ _inverse(self._normal)
        if self._matrix is None:
            flat: Floats = (h / h[2, 2]).ravel()[:8]
            return flat
        m = _inverse(self._matrix) @ h
        m *= np.sign(m[2, 2]) * 2 / (np.linalg.norm(m[:, 0]) + np.linalg.norm(m[:, 1]))
        left, _, right = np.linalg.svd(np.column_stack([m[:, :2], np.cross(m[:, 0], m[:, 1])]))
        turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
        return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), m[:, 2]])

    def to_pixels(self, parameters: Floats) -> Floats:
        """Return the homography (3, 3)."""
        from scipy.spatial.transform import Rotation

        if self._matrix is None:
            h = np.append(parameters[:8], 1.0).reshape(3, 3)
        else:
            turn = Rotation.from_rotvec(parameters[:3]).as_matrix()
            h = self._matrix @ np.column_stack([turn[:, :2], parameters[3:6]])
        found: Floats = h @ self._normal
        return found


def fit_plane(
    pixels: Sequence[Floats],
    positions: Sequence[Floats],
    matrix: Floats | None,
    about: Floats | None = None,
) -> PlaneFit:
    """Return the plane that best fits ideal pixels and positions (mm), (N, 2) for each group.

    The matrix (3, 3) has focal lengths and centre of the camera (px); None = not known. `about` is
    a homography to begin with. ValueError: the points of the first group do not determine it.
    """
    from scipy.optimize import least_squares

    first = PlaneMap.from_points(pixels[0], positions[0]) if about is None else PlaneMap(about)
    centre = positions[0].mean(axis=0)
    scale = float(np.linalg.norm(positions[0] - centre, axis=1).max())
    camera = _Camera(matrix, scale, centre)
    places = [_place(first.to_world(p), x) for p, x in zip(pixels[1:], positions[1:], strict=True)]
    shifts = [np.array((x / scale, y / scale, angle)) for x, y, angle in places]
    start = np.concatenate([camera.start(_inverse(first.matrix)), *shifts])

    def places_of(parameters: Floats) -> Floats:
        shift: Floats = parameters[camera.count :].reshape(-1, 3) * (scale, scale, 1)
        return np.vstack([np.zeros(3), shift])

    def residuals(parameters: Floats) -> Floats:
        to_pixels = camera.to_pixels(parameters)
        seen = [
            _applied(to_pixels, placed(x, place)) - p
            for p, x, place in zip(pixels, positions, places_of(parameters), strict=True)
        ]
        return np.concatenate(seen).ravel()

    best = least_squares(residuals, start, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    ends = np.cumsum([len(p) for p in pixels])[:-1]
    return PlaneFit(
        to_floor=_inverse(camera.to_pixels(best.x)),
        places=places_of(best.x),
        residuals=np.split(best.fun.reshape(-1, 2), ends),
        parameters=best.x,
        jacobian=best.jac,
        view=camera,
    )


def _place(found: Floats, positions: Floats) -> Floats:
    """Return the place (x, y, angle) that brings positions nearest to those that were found."""
    angle, shift, _ = aligned(positions, found)
    return np.array((*shift, angle))


def aligned(positions: Floats, targets: Floats) -> tuple[float, Floats, float]:
    """Return angle (rad) and shift that bring points nearest to others, and the scale they lack.

    The scale is not applied. Source: B. K. P. Horn, Closed-form solution of absolute orientation,
    Journal of the Optical Society of America A 4(4), 1987; in the plane.
    """
    middle, target = positions.mean(axis=0), targets.mean(axis=0)
    one, other = (positions - middle) @ (1, 1j), (targets - target) @ (1, 1j)
    product = complex((np.conj(one) * other).sum())
    angle = float(np.angle(product))
    turned = placed(middle[None], (0, 0, angle))[0]
    spread = float((np.abs(one) ** 2).sum())
    return angle, target - turned, abs(product) / spread if spread else 1.0


def _inverse(matrix: Floats) -> Floats:
    inverse: Floats = np.linalg.inv(matrix).astype(np.float64)
    return inverse


def _applied(homography: Floats, points: Floats) -> Floats:
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    found: Floats = mapped[:, :2] / mapped[:, 2:]
    return found
