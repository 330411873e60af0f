"""Draw the robot "sheep" from above: a fleece with a red and a blue mark, and its black head.

Lengths are in the scene's units in the sheep's frame: x forward, y to its right, origin between
its legs.
"""

from __future__ import annotations

import numpy as np
from draw_lab import reduce_picture, shadow
from draw_scene import FINE, Scene, light
from draw_tools import noise, palette, ramp
from PIL import Image

SIZE = 150.0  # work-area px, the side of the picture
MARKS = {"red": (17.6, 0.4), "blue": (-26.0, -0.6)}  # forward, right
MARK_RADII = (11.8, 14.8)  # along, across

WHOLE = (slice(None), slice(None))

# Materials: (albedo, shine, warmth)
WOOL = (0.66, 0.0, 2.2)
FACE = (0.034, 0.010, 0.8)
EAR = (0.050, 0.006, 1.8)
EYE = (0.010, 0.400, 0.5)
HOOF = (0.016, 0.030, 0.6)

# Paint on wool: the level of the bare wool, and the colour there
PAINT = {
    "red": ((70, (118, 4, 16)), (150, (182, 18, 30)), (215, (222, 52, 56))),
    "blue": ((70, (8, 28, 124)), (150, (22, 62, 184)), (215, (58, 104, 226))),
}


def oval(scene: Scene, where, x: float, y: float, half_x: float, half_y: float, turn: float = 0.0):
    """How far samples lie from the middle of an ellipse, 1 = on its edge."""
    dx, dy = scene.x[where] - x, scene.y[where] - y
    along = dx * np.cos(turn) + dy * np.sin(turn)
    across = dy * np.cos(turn) - dx * np.sin(turn)
    return np.hypot(along / half_x, across / half_y)


def add_dome(scene: Scene, x, y, half_x, half_y, low, high, material, turn=0.0) -> None:
    """Half an ellipsoid, `low` at its edge and `high` in the middle."""
    where = scene.window(x, y, max(half_x, half_y) + 1)
    away = oval(scene, where, x, y, half_x, half_y, turn)
    top = low + (high - low) * np.sqrt(np.clip(1 - away**2, 0, None))
    top = np.where(top > scene.height[where], top, scene.height[where])
    seen = np.where(top > scene.height[where], (1 - away) * min(half_x, half_y), -1)
    scene.put(where, seen, top, material, 0.01)


def add_head(scene: Scene) -> None:
    """Ears, the black face narrowing to the muzzle, and the eyes at its sides."""
    for side in (-1, 1):
        add_dome(scene, 38.0, side * 12.0, 7.6, 3.1, 15.0, 18.0, FACE, side * 1.85)
        add_dome(scene, 38.5, side * 12.6, 5.2, 1.6, 16.6, 18.4, EAR, side * 1.85)
    add_dome(scene, 39.0, 0, 9.5, 8.0, 12.0, 25.0, FACE)
    add_dome(scene, 45.0, 0, 8.6, 6.1, 11.0, 24.5, FACE)
    add_dome(scene, 49.0, 0, 5.2, 5.2, 10.0, 22.5, FACE)
    for side in (-1, 1):
        add_dome(scene, 43.2, side * 6.3, 1.9, 1.1, 16.0, 20.6, EYE, side * 0.35)
        add_dome(scene, 53.0, side * 1.9, 1.1, 0.6, 12.0, 16.5, EYE, side * 0.8)


def add_feet(scene: Scene) -> None:
    """What shows of the four feet beside the body."""
    for x, y, turn in ((20.5, 18.0, 0.2), (24.0, -16.6, -0.1), (-30, 18.7, 0.1), (-33.5, -17.6, 0)):
        add_dome(scene, x, y, 4.4, 2.9, 1.0, 5.0, HOOF, turn)


def body(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the body below its fleece; negative outside."""
    half = 20.5 + 1.6 * np.cos((x + 22) / 14) - 0.0022 * np.clip(x, 0, None) ** 2
    trunk = 1 - np.abs((x + 5) / 37.5) ** 2.7 - np.abs(y / half) ** 2.3
    neck = 1 - ((x - 30) / 10.5) ** 2 - (y / 11.0) ** 2
    tail = 1 - ((x + 44) / 5.5) ** 2 - (y / 3.2) ** 2
    parts = ((29, trunk), (24, neck), (17, tail))
    heights = [np.where(p > 0, h * np.sqrt(np.clip(p, 0, None)), -1) for h, p in parts]
    return np.maximum.reduce(heights)


def lock_places(rng: np.random.Generator) -> np.ndarray:
    """Where locks of wool stand: (n, 2), at random but not crowded."""
    trial = np.column_stack((rng.uniform(-50, 40, 24_000), rng.uniform(-24, 24, 24_000)))
    trial = trial[body(*trial.T) > 0]
    kept = np.empty((0, 2))
    for place in trial:
        if not len(kept) or np.hypot(*(kept - place).T).min() > 2.0:
            kept = np.vstack((kept, place))
    return kept


def add_lock(scene: Scene, x: float, y: float, ground: float, rng: np.random.Generator) -> None:
    """A curl of wool: a bump with a spiral groove."""
    radius = rng.uniform(1.9, 3.1)
    where = scene.window(x, y, radius + 0.5)
    dx, dy = scene.x[where] - x, scene.y[where] - y
    segment, turn = rng.uniform(0.8, 1.2), rng.uniform(0, np.pi)
    away = oval(scene, where, x, y, radius * segment, radius / segment, turn)
    angle = np.arctan2(dy, dx) * rng.choice((-1, 1)) + rng.uniform(0, 6.3)
    spiral = np.cos(2 * np.pi * 1.9 * away - angle)
    top = ground + 2.2 * np.sqrt(np.clip(1 - away**2, 0, None)) + 0.34 * spiral * ramp(away, 0, 0.3)
    inside = np.where(top > scene.height[where], (1 - away) * radius, -1)
    scene.put(where, inside, top, WOOL, 0.25)


def add_fleece(scene: Scene, rng: np.random.Generator) -> None:
    """Locks all over the body, the neck and the tail, and a few between the ears."""
    x, y = scene.x, scene.y
    ground = body(x, y)
    scene.put(WHOLE, np.where(ground > scene.height, 1.0, -1.0), ground, WOOL, 0.01)
    for place_x, place_y in lock_places(rng):
        add_lock(scene, place_x, place_y, float(body(place_x, place_y)), rng)
    for place_x, place_y in rng.normal((38.5, 0), (1.3, 1.9), (26, 2)):
        add_lock(scene, place_x, place_y, 24.5, rng)


def wear(scene: Scene, rng: np.random.Generator) -> None:
    """Fibres, dirt and yellowed tips in the materials."""
    shape = (FINE, FINE)
    albedo, _, warmth = scene.material
    patchy, grain = noise(rng, shape, 70), noise(rng, shape, 2.0)
    wool = albedo > 0.3
    albedo *= 1 + 0.05 * patchy + 0.05 * grain
    dirt = ramp(scene.height, 22, 6) * wool
    albedo *= 1 - 0.35 * dirt
    warmth += wool * (0.5 * patchy + 2.0 * dirt)
    scene.height += 0.03 * noise(rng, shape, 2.5) * (scene.solid > 0)


def add_marks(scene: Scene, rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """`rgb` with the marks sprayed on; locks at their edge take the paint or not."""
    shape = (FINE, FINE)
    ragged = 0.45 * noise(rng, shape, 6) + 0.5 * noise(rng, shape, 26)
    grey = rgb.mean(-1)
    for name, (x, y) in MARKS.items():
        along, across = MARK_RADII
        depth = (1 - oval(scene, WHOLE, x, y, along, across)) * np.sqrt(along * across)
        cover = ramp(depth + 0.9 * ragged, -0.5, 0.5)[..., None]
        rgb = rgb + cover * (palette(grey, PAINT[name]) - rgb)
    return rgb


def draw_sheep() -> Image.Image:
    """The sheep's RGBA picture, facing right."""
    rng = np.random.default_rng(1996)
    scene = Scene()
    add_feet(scene)
    add_head(scene)
    add_fleece(scene, rng)
    wear(scene, rng)
    rgb = add_marks(scene, light(scene), rng)
    alpha = scene.solid + (1 - scene.solid) * shadow(scene)
    picture = reduce_picture(rgb * scene.solid[..., None], alpha)
    return picture.transpose(Image.Transpose.ROTATE_270)
