"""The paint on the face of the portrait's person: lips, eyes and brows.

Colours are linear, 0 to 1. Places are those of the head's own frame, seen from its front.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from draw_tools import palette, ramp

SIDES = (-1, 1)
SMILE = 0.55  # how the mouth's corners rise: up = SMILE * right^2
IRIS = ((0.03, (0.10, 0.14, 0.10)), (0.07, (0.12, 0.17, 0.13)), (0.095, (0.02, 0.03, 0.025)))


@dataclass
class Face:
    """The albedo (n, 3) of points with places x, y, and where they lie on the face's front."""

    rgb: np.ndarray
    x: np.ndarray
    y: np.ndarray
    front: np.ndarray

    def lay(self, cover: np.ndarray, colour) -> None:
        """Paint with a cover of 0 to 1."""
        self.rgb += (cover * self.front)[:, None] * (np.array(colour) - self.rgb)


def paint_face(p: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """The albedo `rgb` (n, 3) of the skin at points (3, n) with the face painted on."""
    x, y, z = p
    face = Face(rgb.copy(), x, y, ramp(z, 0.35, 0.6))
    paint_mouth(face)
    for side in SIDES:
        # Right of the eye's middle, outwards
        out = (side * x - 0.385) / 1.12
        paint_cheek(face, side, out)
        paint_brow(face, out)
        paint_eye(face, side, out)
    return face.rgb


def paint_mouth(face: Face) -> None:
    """The lips and the dark line between them."""
    x = face.x
    y = face.y - SMILE * x * x
    swell = np.clip(1 - (x / 0.35) ** 2, 0, 1)
    upper = -0.94 + 0.095 * swell * (1 - 0.28 * np.exp(-((x / 0.05) ** 2)))
    lower = -0.94 - 0.125 * swell**0.8
    lips = ramp(y, upper + 0.012, upper - 0.012) * ramp(y, lower - 0.015, lower + 0.015)
    face.lay(0.75 * lips * (abs(x) < 0.35), (0.46, 0.15, 0.14))
    gap = ramp(abs(y + 0.945), 0.022, 0.004) * ramp(abs(x), 0.37, 0.29)
    face.lay(0.8 * gap, (0.07, 0.02, 0.02))


def paint_cheek(face: Face, side: int, out: np.ndarray) -> None:
    """A blush, and the nostril."""
    blush = np.exp(-((out / 0.25) ** 2) - ((face.y + 0.38) / 0.2) ** 2)
    face.lay(0.28 * blush, (0.62, 0.22, 0.18))
    nostril = np.hypot((side * face.x - 0.08) / 0.055, (face.y + 0.59) / 0.03)
    face.lay(0.6 * ramp(nostril, 1.2, 0.5), (0.12, 0.045, 0.03))


def paint_brow(face: Face, out: np.ndarray) -> None:
    """A brow that thins out at its ends."""
    arch = 0.315 + 0.045 * np.sin(np.clip((out + 0.24) / 0.55, 0, 1) * np.pi * 0.8)
    thick = 0.046 * ramp(out, -0.30, -0.18) * ramp(out, 0.36, 0.05) ** 0.6 + 0.004
    brow = ramp(abs(face.y - arch), thick * 1.2, thick * 0.3) * (out > -0.29) * (out < 0.35)
    face.lay(0.85 * brow, (0.05, 0.028, 0.017))


def paint_eye(face: Face, side: int, out: np.ndarray) -> None:
    """The eye between its lids, the lashes and the lid's crease."""
    y = face.y
    opening = np.clip(1 - (out / 0.205) ** 2, 0, 1)
    upper, lower = 0.015 + 0.105 * opening**0.7, 0.015 - 0.065 * opening
    inside = ramp(y, upper + 0.008, upper - 0.008) * ramp(y, lower - 0.008, lower + 0.008)
    inside *= (abs(out) < 0.205) * face.front
    # Both eyes look the same way, a little to the viewer's left.
    ball = eyeball(side * out + 0.02, y - 0.045, ramp(y, upper - 0.06, upper))
    face.rgb += inside[:, None] * (ball - face.rgb)
    lashes = ramp(abs(y - upper - 0.008), 0.030, 0.008) * ramp(abs(out), 0.235, 0.19)
    face.lay(0.9 * lashes, (0.015, 0.008, 0.006))
    rim = ramp(abs(y - lower), 0.018, 0.004) * ramp(abs(out), 0.22, 0.17)
    face.lay(0.35 * rim, (0.10, 0.04, 0.03))
    crease = ramp(abs(y - upper - 0.072), 0.022, 0.004) * ramp(abs(out), 0.22, 0.1)
    face.lay(0.4 * crease, (0.18, 0.08, 0.05))


def eyeball(x: np.ndarray, y: np.ndarray, lid_shadow: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of the eye around the pupil's middle."""
    away = np.hypot(x, y)
    white = np.array([0.62, 0.58, 0.55]) * (1 - 0.45 * lid_shadow)[:, None]
    iris = ramp(away, 0.095, 0.080)[:, None]
    ball = white + iris * (palette(away, IRIS) - white)
    ball *= (1 - ramp(away, 0.046, 0.034))[:, None]
    spark = ramp(np.hypot(x + 0.035, y - 0.038), 0.026, 0.014)[:, None]
    return ball + spark * (1.3 - ball)
