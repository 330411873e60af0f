"""Draw the lab floor: worn grey vinyl tiles from above, 1200 x 1200 px, seamless on all sides.

Everything lives on a torus: coordinates wrap modulo SIDE and all blurs are circular, so the
left edge continues into the right one and the top into the bottom. Brightness is in 8-bit levels.
"""

from __future__ import annotations

import numpy as np
from draw_tools import blur, noise, ramp

SIDE = 1200  # px, the side of the picture
TILE = 600  # px, the side of one vinyl tile
SHAPE = (SIDE, SIDE)
BASE = 172.0  # levels, the brightness of clean floor


def stroke(layer: np.ndarray, right: np.ndarray, down: np.ndarray, weight: np.ndarray) -> None:
    """Add points to `layer`, each shared out over its four nearest pixels (wrapped)."""
    x0, y0 = np.floor(right).astype(int), np.floor(down).astype(int)
    fx, fy = right - x0, down - y0
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        share = (fx if dx else 1 - fx) * (fy if dy else 1 - fy) * weight
        index = (y0 + dy) % SIDE * SIDE + (x0 + dx) % SIDE
        layer += np.bincount(index.ravel(), share.ravel(), SIDE * SIDE).reshape(SHAPE)


def wander(
    rng: np.random.Generator, length: float, bend: float, wobble: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A curve from a random place: right, down and heading every half px.

    `bend` is the typical curvature (rad/px), `wobble` the random change of heading (rad/px).
    """
    count = max(int(length * 2), 8)
    turns = rng.normal(0, bend) * 0.5 + rng.normal(0, wobble, count) * 0.5
    heading = rng.uniform(0, 2 * np.pi) + np.cumsum(turns)
    right = rng.uniform(0, SIDE) + np.cumsum(np.cos(heading)) * 0.5
    down = rng.uniform(0, SIDE) + np.cumsum(np.sin(heading)) * 0.5
    return right, down, heading


def smooth_line(rng: np.random.Generator, count: int, grain: float) -> np.ndarray:
    """Random values from 0 to 1 along a line, changing over about `grain` samples."""
    knots = rng.uniform(0, 1, int(count / grain) + 3)
    return np.interp(np.arange(count) / grain, np.arange(knots.size), knots)


def taper(count: int, ends: float = 0.2) -> np.ndarray:
    """1 along a line of `count` samples, falling to 0 over the share `ends` at both ends."""
    t = np.linspace(0, 1, count)
    return ramp(np.minimum(t, 1 - t), 0, ends)


def bristles(
    rng: np.random.Generator,
    layer: np.ndarray,
    curve: tuple[np.ndarray, np.ndarray, np.ndarray],
    width: float,
    strength: float,
    offset: float = 0.0,
) -> None:
    """Rub a streaky band `width` px wide along the curve, `offset` px to its side."""
    right, down, heading = curve
    sides = np.arange(-width / 2, width / 2, 0.6)
    envelope = taper(heading.size) * (0.35 + 0.65 * smooth_line(rng, heading.size, 40))
    for side in sides:
        edge = ramp(width / 2 - abs(side), 0, 0.3 * width)
        streak = smooth_line(rng, heading.size, 25) * rng.uniform(0.15, 1)
        weight = strength * edge * envelope * streak * 0.6
        shift = offset + side
        stroke(layer, right - np.sin(heading) * shift, down + np.cos(heading) * shift, weight)


def tile_pattern(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Brightness of the marbled vinyl, and its warmth; neighbours lie a quarter turn apart."""
    fields = []
    for turned in (False, True):
        flow = (1.0, 2.2) if turned else (2.2, 1.0)
        cloud = noise(rng, SHAPE, (7 * flow[0], 7 * flow[1]))
        fleck = noise(rng, SHAPE, (1.9 * flow[0], 1.9 * flow[1]))
        chip = noise(rng, SHAPE, (1.1 * flow[0], 1.1 * flow[1]))
        dark = ramp(fleck + 0.35 * cloud, 1.1, 1.9)
        pale = ramp(chip - 0.3 * cloud, 1.4, 2.1)
        light = 1.8 * cloud + 1.3 * fleck - 11.0 * dark + 8.0 * pale
        fields.append(np.stack([light, 0.5 * pale - 0.4 * dark]))
    # The joints lie at 300 and 900 px, away from the picture's edges.
    down, right = (np.indices(SHAPE) + TILE // 2) // TILE % 2
    odd = (down + right) % 2 == 1
    light, warm = np.where(odd, fields[1], fields[0])
    step = np.array([[1.6, -2.2], [-1.2, 2.0]])
    return light + step[down, right], warm


def seams(rng: np.random.Generator) -> np.ndarray:
    """The joints between the tiles: a thin dirty line, a soft rim of dirt, a worn edge."""
    total = np.zeros(SHAPE)
    for axis in (0, 1):
        grain = (14, 2) if axis == 0 else (2, 14)
        drift = 0.5 * noise(rng, SHAPE, 60)
        place = np.indices(SHAPE)[1 - axis] + 300.0 + drift
        away = np.abs((place + TILE / 2) % TILE - TILE / 2)
        dirt = np.clip(0.75 + 0.35 * noise(rng, SHAPE, grain), 0.1, 1.5)
        total -= 26 * dirt * np.exp(-((away / 0.9) ** 2))
        total -= 3.0 * dirt * np.exp(-away / 5)
        total += 2.5 * np.exp(-(((away - 2.6) / 1.1) ** 2))
    return total


def scratches(rng: np.random.Generator) -> np.ndarray:
    """Hairline scratches, mostly pale, some filled with dirt, plus short nicks."""
    layer = np.zeros(SHAPE)
    for _ in range(230):
        length = rng.lognormal(4.0, 0.9)
        right, down, heading = wander(rng, min(length, 900), 0.0012, 0.004)
        strength = rng.choice([1.0, 1.0, -0.9]) * rng.uniform(2, 9)
        skips = np.clip(1.6 * smooth_line(rng, heading.size, 18) - 0.35, 0, 1)
        stroke(layer, right, down, strength * taper(heading.size) * skips)
    for _ in range(260):
        right, down, heading = wander(rng, rng.uniform(3, 14), 0.03, 0.02)
        strength = rng.choice([1.0, -1.0]) * rng.uniform(2, 9)
        stroke(layer, right, down, strength * taper(heading.size, 0.4))
    return blur(layer, 0.45)


def scuffs(rng: np.random.Generator) -> np.ndarray:
    """Rubber marks of shoes and chair castors: short, dark, streaky; and paler rubbed places."""
    layer = np.zeros(SHAPE)
    for _ in range(60):
        curve = wander(rng, rng.lognormal(3.6, 0.6), 0.012, 0.01)
        bristles(rng, layer, curve, rng.uniform(1.5, 7), -rng.lognormal(2.9, 0.5))
    for _ in range(14):
        curve = wander(rng, rng.uniform(40, 160), 0.006, 0.004)
        bristles(rng, layer, curve, rng.uniform(6, 18), rng.uniform(6, 12))
    return blur(layer, 0.7)


def wheel_marks(rng: np.random.Generator) -> np.ndarray:
    """Faint pairs of tracks, as wide apart as the robot's wheels, and a few single ones."""
    layer = np.zeros(SHAPE)
    for _ in range(6):
        curve = wander(rng, rng.uniform(250, 700), 0.004, 0.003)
        for offset in (-47, 47):
            bristles(rng, layer, curve, 8, -rng.uniform(9, 16), offset)
    for _ in range(5):
        curve = wander(rng, rng.uniform(200, 800), 0.002, 0.003)
        bristles(rng, layer, curve, rng.uniform(10, 16), -rng.uniform(6, 11))
    return blur(layer, 0.9)


def spots(rng: np.random.Generator) -> np.ndarray:
    """Dirt: tiny dark and pale specks, and a few dried drops with a darker rim."""
    layer = np.zeros(SHAPE)
    for count, size, strength in ((900, 0.5, 20), (140, 1.0, 60), (22, 1.7, 120)):
        points = np.zeros(SHAPE)
        weight = rng.choice([-1.0, -1.0, 0.7], count) * rng.uniform(0.2, 1, count) * strength
        stroke(points, rng.uniform(0, SIDE, count), rng.uniform(0, SIDE, count), weight)
        layer += blur(points, size)
    down, right = np.indices(SHAPE)
    crooked = noise(rng, SHAPE, 12)
    for _ in range(16):
        x, y, radius = rng.uniform(0, SIDE), rng.uniform(0, SIDE), rng.lognormal(2.3, 0.55)
        dx = (right - x + SIDE / 2) % SIDE - SIDE / 2
        dy = (down - y + SIDE / 2) % SIDE - SIDE / 2
        inside = radius * (1 + 0.12 * crooked) - np.hypot(dx, dy)
        strength = rng.uniform(1, 3.5)
        layer -= strength * (0.4 * ramp(inside, -1, 2) + np.exp(-((inside / 1.6) ** 2)))
    return layer


def tape(
    rng: np.random.Generator, floor: np.ndarray, place: tuple[float, float, float, float, float]
) -> np.ndarray:
    """`floor` with a worn strip of tape: (right, down, degrees, length, width), px."""
    x, y, degrees, length, width = place
    down, right = np.indices(SHAPE)
    dx = (right - x + SIDE / 2) % SIDE - SIDE / 2
    dy = (down - y + SIDE / 2) % SIDE - SIDE / 2
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    along, across = dx * cos + dy * sin, dy * cos - dx * sin
    ragged = 1.6 * noise(rng, SHAPE, 3) + 1.0 * noise(rng, SHAPE, 9)
    inside = np.minimum(length / 2 - abs(along) + ragged, width / 2 - abs(across) + 0.12 * ragged)
    near_edge = np.exp(-np.clip(inside, 0, None) / 6)
    wear = 1.1 * noise(rng, SHAPE, 5) + 0.8 * noise(rng, SHAPE, 1.3) + noise(rng, SHAPE, 22)
    kept = ramp(wear - 1.6 * near_edge, -2.9, -2.3)
    cover = ramp(inside, -0.5, 0.8) * (0.25 + 0.65 * kept)
    crease = noise(rng, SHAPE, (0.8, 5) if abs(sin) > 0.7 else (5, 0.8))
    colour = 193 + 1.6 * crease + 2.5 * noise(rng, SHAPE, 14) + 0.35 * (floor - BASE)
    rim = -9 * np.exp(-(((inside + 1.2) / 1.3) ** 2)) * (0.4 + 0.6 * kept)
    return floor * (1 - cover) + colour * cover + rim


def draw_floor() -> np.ndarray:
    """The floor as SIDE x SIDE x 3 levels (uint8)."""
    rng = np.random.default_rng(20240)
    pattern, warm = tile_pattern(rng)
    floor = BASE + pattern
    for place in ((1010, 110, 91.2, 330, 26), (395, 700, 1.0, 230, 26)):
        floor = tape(rng, floor, place)
    uneven = (
        3.6 * noise(rng, SHAPE, 150) + 2.6 * noise(rng, SHAPE, 55) + 1.4 * noise(rng, SHAPE, 20)
    )
    grime = np.clip(noise(rng, SHAPE, 35) + 0.5 * noise(rng, SHAPE, 4), 0, None)
    floor += uneven - 2.2 * grime + seams(rng)
    floor += scuffs(rng) + wheel_marks(rng) + scratches(rng) + spots(rng)
    # The lens softens a little, the sensor adds a fine grain.
    floor = blur(floor, 0.55) + 1.5 * noise(rng, SHAPE, 0.5)
    floor = np.clip(floor, 60, 235)
    warmth = 0.012 + 0.006 * blur(warm, 1.0) + 0.0022 * noise(rng, SHAPE, 90)
    rgb = floor[..., None] * (1 + warmth[..., None] * np.array([1.0, 0.15, -1.6]))
    return np.clip(np.round(rgb), 0, 255).astype(np.uint8)
