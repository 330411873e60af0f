"""Rounded solids as distance fields, and the light on them.

Points are arrays (3, n): right, up, towards the viewer. A field gives the distance to its solid
for such points, negative inside. The view is straight along -z, without perspective.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Field = Callable[[np.ndarray], np.ndarray]


def unit_vector(right: float, up: float, front: float) -> np.ndarray:
    """The direction of a vector."""
    vector = np.array([right, up, front])
    return vector / np.linalg.norm(vector)


def ellipsoid(p: np.ndarray, centre, radii) -> np.ndarray:
    """Distance to an ellipsoid, nearly."""
    q = p - np.array(centre, np.float32)[:, None]
    r = np.array(radii, np.float32)[:, None]
    near = np.sqrt(np.square(q / r).sum(0))
    return near * (near - 1) / np.maximum(np.sqrt(np.square(q / (r * r)).sum(0)), 1e-6)


def capsule(p: np.ndarray, start, end, start_radius: float, end_radius: float) -> np.ndarray:
    """Distance to a rod with round ends whose radius changes along it."""
    a, b = (np.array(point, np.float32) for point in (start, end))
    q, rod = p - a[:, None], b - a
    along = np.clip(rod @ q / (rod @ rod), 0, 1)
    away = np.sqrt(np.square(q - rod[:, None] * along).sum(0))
    return away - (start_radius + (end_radius - start_radius) * along)


def join(a: np.ndarray, b: np.ndarray, soft: float) -> np.ndarray:
    """Both solids, with a rounded fillet of about `soft` where they meet."""
    mix = np.clip(0.5 + 0.5 * (b - a) / soft, 0, 1)
    return b + (a - b) * mix - soft * mix * (1 - mix)


def carve(a: np.ndarray, b: np.ndarray, soft: float) -> np.ndarray:
    """Solid `a` without `b`, with a rounded edge."""
    return -join(-a, b, soft)


def turned(p: np.ndarray, yaw: float, roll: float, around) -> np.ndarray:
    """Points in the frame of a part turned to the viewer's right by yaw and tilted by roll."""
    pivot = np.array(around, np.float32)[:, None]
    x, y, z = p - pivot
    x, y = np.cos(roll) * x - np.sin(roll) * y, np.sin(roll) * x + np.cos(roll) * y
    x, z = np.cos(yaw) * x - np.sin(yaw) * z, np.sin(yaw) * x + np.cos(yaw) * z
    return np.stack([x, y, z]) + pivot


def march(field: Field, x: np.ndarray, y: np.ndarray, near: float, far: float) -> np.ndarray:
    """Height z that a viewer sees at each place; `far` where there is nothing."""
    z = np.full(x.shape, near, np.float32)
    live = np.arange(x.size)
    for _ in range(90):
        step = field(np.stack([x[live], y[live], z[live]]))
        z[live] -= 0.75 * step
        live = live[(step > 5e-4) & (z[live] > far)]
        if not live.size:
            break
    return np.maximum(z, far)


def normals(field: Field, p: np.ndarray, reach: float = 0.006) -> np.ndarray:
    """Unit normals at points of the surface."""
    corners = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1]], np.float32)
    total = sum(c[:, None] * field(p + reach * c[:, None]) for c in corners)
    return total / np.maximum(np.sqrt(np.square(total).sum(0)), 1e-9)


def openness(field: Field, p: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """1 where the surface is open to the sky, towards 0 in corners and folds."""
    closed = np.zeros(p.shape[1], np.float32)
    for reach, weight in ((0.05, 0.9), (0.14, 0.7), (0.32, 0.5), (0.7, 0.35)):
        closed += weight * np.clip(1 - field(p + reach * normal) / reach, 0, 1.2)
    return np.exp(-0.75 * closed)


def lit(field: Field, p: np.ndarray, towards: np.ndarray, softness: float = 5.0) -> np.ndarray:
    """1 where the light falls, 0 in the shadow of other parts, soft in between."""
    result = np.ones(p.shape[1], np.float32)
    way = np.full(p.shape[1], 0.05, np.float32)
    for _ in range(26):
        room = field(p + way * towards[:, None])
        result = np.minimum(result, np.clip(0.5 + 0.5 * softness * room / way, 0, 1))
        way += np.clip(room, 0.03, 0.25)
    return result * result * (3 - 2 * result)
