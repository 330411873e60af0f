"""Draw the robot "lab" from above: its picture with transparent surroundings, and its outline.

Lengths are in work-area px in the robot's frame: x forward, y to its right, origin at its centre.
"""

from __future__ import annotations

import numpy as np
from draw_scene import (
    ACRYLIC,
    BOARD,
    FINE,
    HOLE,
    METAL,
    PACK,
    PER_PX,
    PLASTIC,
    PRINT,
    RUBBER,
    SIZE,
    SOLDER,
    Scene,
    box_depth,
    light,
)
from draw_tools import blur, noise, ramp
from PIL import Image

PICTURE = 480  # picture px, the side of the picture
DECK_RADIUS = 50.0
MARKER_RADIUS = 13.0
MARKERS = {"red": (-14.0, 21.5), "blue": (-14.0, -21.5)}
PLATE_SCREWS = ((2.2, -36.7, 1.1), (2.2, 36.7, 0.2), (-35, -14, 0.5), (-35, 14, 1.3))  # x, y, turn
MARKER_COLOURS = {"red": (205.0, 38.0, 42.0), "blue": (28.0, 72.0, 205.0)}

# Cables as (top, radius, control points); the long ones run between the markers, well clear of
# the dark rims around them.
# fmt: off
CABLES = (
    (20.4, 0.9, ((12, -4.5), (7, -3.4), (4, -1.4), (-8, -1), (-24, -1), (-31, -2.6), (-41, -2.2))),
    (20.6, 0.9, ((14, -3.6), (8, -1.4), (3, 0.9), (-9, 1.0), (-22, 0.8), (-31, 2.8), (-41, 2.0))),
    (22.5, 0.7, ((9, 0.3), (12, 2.6), (9.5, 5.0), (10.2, 9.5))),
    (22.6, 0.65, ((38, 1), (35, 2), (33, -1), (28, 1), (24, 2), (18, 1.5), (12, 6), (10.3, 12))),
    (22.6, 0.65, ((38, 3), (35, 4), (34, 1), (28, 2.6), (22, 1), (17, 3.4), (13, 8), (10.3, 14))),
)
# fmt: on


def add_wheels(scene: Scene) -> None:
    """Two black rubber tyres; their tread bars bunch up where the tyre curves away."""
    radius, half_width = 17.0, 5.1
    for y in (-46.7, 46.7):
        where = scene.window(0, y, radius + 1)
        dx, dy = scene.x[where], scene.y[where] - y
        inside = box_depth(dx, dy, radius - 0.3, half_width, 1.8)
        angle = np.arcsin(np.clip(dx / radius, -1, 1))
        # Chevron bars, 30 around the tyre, with a groove along the middle.
        phase = angle * 30 / (2 * np.pi) + 0.16 * abs(dy)
        bar = ramp(np.cos(2 * np.pi * phase), -0.55, 0.15) * ramp(abs(dy), 0.35, 0.8)
        top = 2.0 + 17.0 * np.cos(angle) + 1.1 * bar
        scene.put(where, inside, top, RUBBER, 1.6)
        # Dust greys the bars, the grooves stay black.
        scene.material[0][where] += 0.022 * bar * (inside > 0)


def add_chassis(scene: Scene) -> None:
    """The round deck with slots for the wheels, and the raised plate that bears the markers."""
    where = scene.window(0, 0, DECK_RADIUS + 1)
    x, y = scene.x, scene.y
    round_edge = DECK_RADIUS - np.hypot(x, y)
    slot = np.maximum(box_depth(x, y - 52, 19.5, 11.2, 2.5), box_depth(x, y + 52, 19.5, 11.2, 2.5))
    scene.put(where, np.minimum(round_edge, -slot)[where], 14.0, ACRYLIC, 0.5)
    for side in (-1, 1):
        scene.box(33, side * 31.5, 5.5, 1.2, 12.0, HOLE, 1.2, 0.1)
        scene.box(-41, side * 12, 1.2, 3.5, 12.0, HOLE, 1.2, 0.1)
        scene.disc(25, side * 38.5, 1.2, 12.0, HOLE, 0.1)
        scene.box(0, side * 40.8, 1.5, 1.3, 16.0, METAL, 0.3)
    plate = np.minimum(box_depth(x, y, 38.5, 40.3, 7), 47.3 - np.hypot(x, y))
    plate = np.minimum(plate, 5.8 - x)
    scene.put(where, plate[where], 18.5, ACRYLIC, 0.5)
    for x, y, turn in PLATE_SCREWS:
        scene.screw(x, y, 18.5, turn, 1.8)
    for side in (-1, 1):
        scene.screw(-45.5, side * 6.5, 14.0, 0.7 + side, 1.5)


def add_front(scene: Scene) -> None:
    """The range finder at the front edge: two metal cans before a small upright board."""
    scene.box(38.2, 0, 2.6, 10, 15.5, METAL, 0.5)
    scene.box(40.6, 0, 0.8, 21.5, 27.0, BOARD, 0.3, 0.2)
    for y in (-11.5, 11.5):
        scene.lying_can(46.0, y, 4.9, 7.2, 27.0, METAL)
        scene.lying_can(50.6, y, 0.7, 7.4, 27.2, METAL)
        scene.lying_can(51.4, y, 0.35, 6.0, 25.0, PLASTIC)
    scene.box(42.6, 0, 1.3, 2.6, 24.0, METAL, 1.2, 1.0)
    for pin in range(4):
        scene.box(38.6, -3.0 + 2 * pin, 1.7, 0.35, 22.0, SOLDER, 0.1, 0.1)


def add_electronics(scene: Scene, rng: np.random.Generator) -> None:
    """The controller board on the right half of the front."""
    scene.box(21.2, 18.5, 13.6, 14.5, 17.5, BOARD, 2, 0.2)
    for x, y in ((10.0, 30.6), (32.4, 30.6), (32.4, 6.6)):
        scene.disc(x, y, 2.0, 17.6, SOLDER, 0.1)
        scene.screw(x, y, 17.6, rng.uniform(0, 3), 1.25)
    scene.box(23.5, 18.0, 4.6, 4.6, 19.0, PLASTIC, 0.3, 0.3)
    scene.disc(26.9, 14.6, 0.45, 18.9, HOLE, 0.1)
    for pin in np.linspace(-3.8, 3.8, 10):
        for side in (-5.3, 5.3):
            scene.box(23.5 + pin, 18.0 + side, 0.22, 0.75, 17.9, SOLDER, 0.1, 0.1)
            scene.box(23.5 + side, 18.0 + pin, 0.75, 0.22, 17.9, SOLDER, 0.1, 0.1)
    scene.box(10.2, 18.0, 1.5, 9.6, 21.5, PLASTIC, 0.2, 0.2)
    for pin in range(9):
        scene.box(10.2, 10.0 + 2 * pin, 0.45, 0.45, 20.5, HOLE, 0.1, 0.1)
    scene.box(21.0, 30.6, 3.6, 2.6, 20.5, METAL, 0.4, 0.5)
    scene.disc(30.2, 24.5, 2.5, 22.5, METAL, 0.5)
    scene.disc(30.2, 24.5, 1.9, 22.3, METAL, 0.2)
    scene.box(16.2, 9.0, 1.0, 2.3, 18.8, METAL, 0.9, 0.5)
    scene.box(31.4, 14.0, 1.9, 2.2, 20.0, (0.06, 0.03, 0.0), 0.5, 0.4)
    for _ in range(26):
        x, y = rng.uniform(14, 33.5), rng.uniform(6, 31)
        if (abs(x - 23.5) < 7.4 and abs(y - 18) < 7.4) or np.hypot(x - 30.2, y - 24.5) < 4:
            continue
        if scene.height[scene.window(x, y, 0.8)].max() > 17.9:
            continue
        long, thin = (0.75, 0.4) if rng.random() < 0.5 else (0.4, 0.75)
        scene.box(x, y, long, thin, 18.0, SOLDER, 0.1, 0.1)
        scene.box(x, y, long * 0.6, thin, 18.1, PLASTIC, 0.1, 0.1)
    for x, y, half_x, half_y in ((18.4, 12.2, 0.15, 0.9), (28.8, 31.5, 1.4, 0.15)):
        scene.box(x, y, half_x, half_y, 17.6, PRINT, 0.1, 0.1)


def add_battery(scene: Scene, rng: np.random.Generator) -> None:
    """The checks pack on the left half of the front, its strap, cable and switch."""
    scene.box(21.4, -17.5, 12.4, 14.6, 23.5, PACK, 2.6, 2.2)
    where = scene.window(21.4, -17.5, 14)
    crinkle = noise(rng, (FINE, FINE), (18, 44))[where]
    scene.height[where] += 0.10 * crinkle * (scene.height[where] > 20)
    scene.box(20.6, -18.2, 4.2, 6.2, 23.6, (0.42, 0.02, 0.2), 0.4, 0.1)
    for line in range(4):
        length = (5.0, 3.8, 4.6, 2.4)[line]
        scene.box(23 - 1.6 * line, -23.2 + length, 0.28, length, 23.7, (0.12, 0.0, 0.0), 0.1, 0.1)
    scene.box(29.6, -17.5, 2.4, 15.4, 24.4, RUBBER, 0.4, 0.5)
    scene.box(-42.6, 0, 2.0, 3.6, 19.0, PLASTIC, 0.4)
    scene.box(-42.6, 0.9, 0.9, 1.1, 21.0, METAL, 0.2)
    # Cables run between the markers, well clear of the dark rims around them.
    for top, radius, points in CABLES:
        scene.wire(points, top, radius)
    scene.box(-14, 0, 1.0, 2.6, 21.6, PLASTIC, 0.4, 0.3)


def wear(scene: Scene, rng: np.random.Generator) -> None:
    """Dust, smudges and hairline scratches in the materials."""
    shape = (FINE, FINE)
    albedo, shine, warmth = scene.material
    smudge = noise(rng, shape, 90) + 0.6 * noise(rng, shape, 25)
    grain = noise(rng, shape, 1.5)
    albedo *= np.clip(1 + 0.10 * smudge + 0.06 * grain, 0.5, 1.6)
    shine *= np.clip(1 - 0.22 * smudge + 0.03 * grain, 0.3, 1.8)
    dust = ramp(noise(rng, shape, 2.2), 2.9, 3.6) + 0.6 * ramp(noise(rng, shape, 4), 3.2, 3.9)
    albedo += 0.05 * dust + 0.004 * np.clip(smudge, 0, None)
    for _ in range(70):
        x, y = rng.uniform(-48, 30), rng.uniform(-46, 46)
        turn, length = rng.uniform(0, np.pi), rng.lognormal(1.4, 0.6)
        where = scene.window(x, y, length + 1)
        dx, dy = scene.x[where] - x, scene.y[where] - y
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        line = np.exp(-(((across - 0.01 * along**2) / 0.10) ** 2)) * ramp(abs(along), length, 0)
        albedo[where] += rng.uniform(0.005, 0.030) * line
    warmth += 0.5 * noise(rng, shape, 120)


def add_markers(scene: Scene, rgb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """`rgb` with the paper discs glued on; their edge is crisp, their wear stays inside."""
    shape = (FINE, FINE)
    # Grain of a few samples survives the reduction to the picture's size.
    fibre = 3.2 * noise(rng, shape, 3.2) + 1.2 * noise(rng, shape, 9)
    fade = 1 + 0.018 * noise(rng, shape, 70)
    for name, (x, y) in MARKERS.items():
        away = np.hypot(scene.x - x, scene.y - y)
        rim = np.exp(-(np.clip(away - MARKER_RADIUS, 0, None) / 0.45))
        rgb = rgb * (1 - 0.35 * rim)[..., None]
        worn = 0.10 * ramp(noise(rng, shape, 3.0) + 0.7 * noise(rng, shape, 14), 2.3, 3.2)
        worn *= ramp(away, MARKER_RADIUS - 0.6, MARKER_RADIUS - 2)
        paper = np.array(MARKER_COLOURS[name]) * fade[..., None] + fibre[..., None]
        paper += worn[..., None] * (190 - paper)
        cover = np.clip((MARKER_RADIUS - away) * PER_PX + 0.5, 0, 1)[..., None]
        rgb = rgb * (1 - cover) + paper * cover
    return rgb


def shadow(scene: Scene) -> np.ndarray:
    """Alpha of the soft contact shadow, the same on all sides, gone before the picture's edge."""
    wide = blur(scene.solid, 3.2 * PER_PX)
    close = blur(scene.solid, 1.1 * PER_PX)
    fade = ramp(np.hypot(scene.x, scene.y), 59.5, 52)
    return np.clip(0.48 * wide + 0.48 * close, 0, 1) * fade


def reduce_picture(rgb: np.ndarray, alpha: np.ndarray) -> Image.Image:
    """The RGBA picture at its final size; `rgb` is already multiplied by alpha."""
    layers = [rgb[..., 0], rgb[..., 1], rgb[..., 2], alpha]
    small = []
    for layer in layers:
        image = Image.fromarray(layer.astype(np.float32))
        small.append(np.asarray(image.resize((PICTURE, PICTURE), Image.Resampling.HAMMING)))
    colours = np.stack(small[:3], -1) / np.maximum(small[3], 1e-3)[..., None]
    rgba = np.concatenate([colours, 255 * small[3][..., None]], -1)
    return Image.fromarray(np.clip(np.round(rgba), 0, 255).astype(np.uint8), "RGBA")


def to_picture(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Robot frame (x forward, y right) to picture px [right, down], facing up."""
    scale, middle = PICTURE / SIZE, (PICTURE - 1) / 2
    return np.stack([middle + scale * np.asarray(y), middle - scale * np.asarray(x)], -1)


def marker_polygon(name: str, corners: int = 24) -> np.ndarray:
    """The regular polygon in picture px with the area and the centroid of the marker's disc."""
    turn = 2 * np.pi * np.arange(corners) / corners
    radius = MARKER_RADIUS * np.sqrt(2 * np.pi / (corners * np.sin(2 * np.pi / corners)))
    x, y = MARKERS[name]
    return to_picture(x + radius * np.cos(turn), y + radius * np.sin(turn))


def outline_polygon(scene: Scene, corners: int = 36) -> np.ndarray:
    """The polygon in picture px whose sides touch the solid parts from all around."""
    turn = 2 * np.pi * (np.arange(corners) + 0.5) / corners
    edge = scene.solid > 0.5
    edge &= np.hypot(scene.x, scene.y) > 45
    x, y = scene.x[edge], scene.y[edge]
    reach = np.array([(x * np.cos(a) + y * np.sin(a)).max() for a in turn]) + 0.5 / PER_PX
    points = []
    for i in range(corners):
        pair = turn[[i - 1, i]]
        sides = np.stack([np.cos(pair), np.sin(pair)], -1)
        points.append(np.linalg.solve(sides, reach[[i - 1, i]]))
    return to_picture(*np.array(points).T)


def draw_lab() -> tuple[Image.Image, np.ndarray]:
    """The robot's RGBA picture and its outline in picture px."""
    rng = np.random.default_rng(4711)
    scene = Scene()
    add_chassis(scene)
    add_wheels(scene)
    add_battery(scene, rng)
    add_electronics(scene, rng)
    add_front(scene)
    wear(scene, rng)
    rgb = add_markers(scene, light(scene), rng)
    alpha = scene.solid + (1 - scene.solid) * shadow(scene)
    return reduce_picture(rgb * scene.solid[..., None], alpha), outline_polygon(scene)
