"""The person of the portrait: the shapes of head, hair and jacket.

Lengths are in halves of the head's width; the eyes are at the height 0.
"""

from __future__ import annotations

import numpy as np
from draw_face import SIDES, SMILE
from draw_solids import capsule, carve, ellipsoid, join, turned
from draw_tools import noise, ramp

YAW, ROLL, NECK = 0.20, 0.06, (0.0, -1.3, -0.3)  # how the head is held (rad), around where
STITCHES = 0.62  # between the jacket's quilted seams


def head_frame(p: np.ndarray) -> np.ndarray:
    """Points in the head's own frame."""
    return turned(p, YAW, ROLL, NECK)


def head(p: np.ndarray) -> np.ndarray:
    """Skull, face, nose, lips and ears, in the head's frame."""
    d = ellipsoid(p, (0, 0.45, -0.25), (0.98, 1.05, 1.15))
    d = join(d, ellipsoid(p, (0, -0.33, 0.12), (0.83, 1.05, 0.88)), 0.25)
    d = join(d, ellipsoid(p, (0, -1.20, 0.56), (0.27, 0.20, 0.27)), 0.30)
    d = join(d, ellipsoid(p, (0, -0.88, 0.70), (0.36, 0.32, 0.28)), 0.22)
    for s in SIDES:
        d = join(d, ellipsoid(p, (s * 0.50, -0.36, 0.68), (0.27, 0.23, 0.21)), 0.28)
        d = join(d, ellipsoid(p, (s * 0.34, 0.29, 0.79), (0.30, 0.13, 0.11)), 0.24)
        d = carve(d, ellipsoid(p, (s * 0.39, 0.03, 1.11), (0.25, 0.15, 0.21)), 0.18)
        d = join(d, ellipsoid(p, (s * 0.38, 0.01, 0.71), (0.215, 0.19, 0.20)), 0.05)
        d = join(d, ellipsoid(p, (s * 0.98, -0.15, -0.15), (0.09, 0.32, 0.2)), 0.06)
    d = join(d, capsule(p, (0, 0.20, 0.90), (0, -0.40, 1.09), 0.070, 0.10), 0.15)
    d = join(d, ellipsoid(p, (0, -0.48, 1.10), (0.13, 0.11, 0.13)), 0.08)
    for s in SIDES:
        d = join(d, ellipsoid(p, (s * 0.14, -0.52, 1.01), (0.08, 0.08, 0.10)), 0.06)
        d = carve(d, ellipsoid(p, (s * 0.072, -0.595, 1.10), (0.04, 0.025, 0.06)), 0.03)
    smile = SMILE * np.square(p[0])
    q = np.stack([p[0], p[1] - smile, p[2]])
    d = join(d, ellipsoid(q, (0, -0.875, 0.955), (0.27, 0.065, 0.09)), 0.06)
    d = join(d, ellipsoid(q, (0, -1.01, 0.95), (0.23, 0.08, 0.095)), 0.06)
    return carve(d, ellipsoid(q, (0, -0.94, 1.08), (0.30, 0.016, 0.09)), 0.03)


def hair(p: np.ndarray, strands: np.ndarray) -> np.ndarray:
    """A bob with a parting, in the head's frame; `strands` lifts it."""
    d = ellipsoid(p, (0, 0.40, -0.28), (1.16, 1.28, 1.22))
    for s in SIDES:
        lock = capsule(p, (s * 0.95, 0.30, -0.10), (s * 0.98, -1.20, -0.02), 0.32, 0.30)
        d = join(d, lock, 0.35)
    d = join(d, ellipsoid(p, (0, -0.7, -0.75), (1.1, 1.0, 0.55)), 0.3)
    d = d - 0.015 * strands - 0.05 * strands * ramp(p[1], -0.9, -1.5)
    # The face is open: an oval, its top leaning to the parting.
    x, y = p[0] - 0.10 * ramp(p[1], 0.2, 1.0), p[1] + 0.42
    oval = (np.hypot(x / 0.84, y / 1.30) - 1) * 0.84
    return carve(d, np.maximum(oval, 0.12 - p[2]), 0.10)


def look_up(field: np.ndarray, down: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Values of a field that tiles, linear between its samples."""
    top, left = np.floor(down).astype(int), np.floor(right).astype(int)
    part_down, part_right = (down - top).astype(np.float32), (right - left).astype(np.float32)
    rows, columns = field.shape
    upper = field[top % rows, left % columns] * (1 - part_right)
    upper += field[top % rows, (left + 1) % columns] * part_right
    lower = field[(top + 1) % rows, left % columns] * (1 - part_right)
    lower += field[(top + 1) % rows, (left + 1) % columns] * part_right
    return upper + part_down * (lower - upper)


class Strands:
    """Strands of hair: noise that changes quickly across them and slowly along."""

    def __init__(self, rng: np.random.Generator) -> None:
        shape = (1024, 512)
        coarse, fine = noise(rng, shape, (8, 60)), noise(rng, shape, (1.5, 50))
        middle = noise(rng, shape, (3.2, 70))
        self.lift = (0.7 * coarse + 0.4 * middle + 0.15 * fine).astype(np.float32)
        self.tone = (0.25 * coarse + 0.45 * middle + 0.85 * fine).astype(np.float32)

    def lift_at(self, p: np.ndarray) -> np.ndarray:
        """How far the strands stand out at points in the head's frame."""
        return look_up(self.lift, *along_the_hair(p))

    def tone_at(self, p: np.ndarray) -> np.ndarray:
        """How light the strands are at points in the head's frame."""
        return look_up(self.tone, *along_the_hair(p))


def along_the_hair(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places across and along the strands, which fall from the parting to both sides."""
    x, y = p[0] - 0.32, p[1] - 0.1
    across = np.hypot(x / 1.16, np.maximum(y, 0) / 1.3) + 0.12 * p[2]
    along = np.where(y > 0, np.arctan2(abs(x), np.maximum(y, 0)), 1.6 - y)
    across = np.where(x > 0, 2.5 + across, across) + 0.02 * np.sin(4 * along)
    return 230 * across, 90 * along


def neck(p: np.ndarray) -> np.ndarray:
    """Neck and the top of the chest."""
    d = capsule(p, (0.02, -1.0, -0.30), (0, -2.3, -0.50), 0.47, 0.54)
    return join(d, ellipsoid(p, (0, -2.75, -0.50), (0.9, 0.75, 0.62)), 0.3)


def shirt(p: np.ndarray) -> np.ndarray:
    """A T-shirt with a round neck."""
    d = ellipsoid(p, (0, -2.85, -0.50), (0.95, 1.0, 0.66))
    return np.maximum(d, 1 - np.hypot(p[0] / 0.62, (p[1] + 1.62) / 0.80))


def quilt(p: np.ndarray, wrinkles: np.ndarray) -> np.ndarray:
    """How far the padding swells between the seams, 0 at a seam."""
    x, y, _ = p
    sag = 0.09 * np.square(np.minimum(abs(x), 2.2)) + 0.03 * np.sin(1.7 * x + 0.6)
    phase = (y + sag + 0.015 * wrinkles) / STITCHES
    return np.sqrt(abs(np.sin(np.pi * phase)) + 0.01)


class Wrinkles:
    """Creases of the padded cloth, read at the place in the view."""

    def __init__(self, rng: np.random.Generator) -> None:
        shape = (512, 512)
        wide, fine = noise(rng, shape, (22, 8)), noise(rng, shape, (9, 3.0))
        self.lift = (0.6 * wide + 0.5 * fine).astype(np.float32)

    def lift_at(self, p: np.ndarray) -> np.ndarray:
        """How far the cloth is lifted at points; about -2 .. 2."""
        return look_up(self.lift, 64 * p[1], 64 * (p[0] + 0.3 * p[2]))


def jacket(p: np.ndarray, wrinkles: np.ndarray) -> np.ndarray:
    """A quilted jacket, zipped up to the chest, with a padded stand-up collar."""
    d = ellipsoid(p, (0, -4.6, -0.55), (1.95, 2.6, 1.18))
    for s in SIDES:
        top = capsule(p, (s * 0.45, -2.35, -0.6), (s * 1.70, -2.90, -0.55), 0.58, 0.58)
        d = join(d, top, 0.4)
        arm = capsule(p, (s * 1.80, -2.97, -0.5), (s * 2.40, -6.0, -0.2), 0.66, 0.60)
        d = join(d, arm, 0.10)
    zipper = ramp(abs(p[0]), 0.03, 0.12)
    d = d - 0.062 * quilt(p, wrinkles) * (0.25 + 0.75 * zipper) - 0.014 * wrinkles * zipper
    opening = np.maximum(abs(p[0]) - 0.50 * np.clip((p[1] + 2.90) / 0.9, 0, 1), -0.2 - p[2])
    d = carve(d, np.maximum(opening, -2.90 - p[1]), 0.08)
    for s in SIDES:
        back = (s * 0.62, -1.55, -0.75)
        side = (s * 0.70, -1.80, -0.05)
        front = (s * 0.13, -2.78, 0.30)
        d = join(d, capsule(p, back, side, 0.22, 0.24) - 0.012 * wrinkles, 0.06)
        d = join(d, capsule(p, side, front, 0.24, 0.16) - 0.012 * wrinkles, 0.06)
    return d


class Person:
    """The whole person: a field, and those of its parts."""

    SKIN, HAIR, JACKET, SHIRT = range(4)

    def __init__(self, rng: np.random.Generator) -> None:
        self.strands, self.wrinkles = Strands(rng), Wrinkles(rng)

    def parts(self, p: np.ndarray) -> list[np.ndarray]:
        """Distances to skin, hair, jacket and shirt."""
        q = head_frame(p)
        skin = join(head(q), neck(p), 0.12)
        return [
            skin,
            hair(q, self.strands.lift_at(q)),
            jacket(p, self.wrinkles.lift_at(p)),
            shirt(p),
        ]

    def __call__(self, p: np.ndarray) -> np.ndarray:
        """Distance to the person."""
        return np.minimum.reduce(self.parts(p))
