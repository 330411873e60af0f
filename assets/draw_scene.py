"""Parts of a robot seen from above, as a height map with materials, and the light on them.

Lengths are in work-area px in the robot's frame: x forward, y to its right, origin at its centre.
Occlusion by higher neighbours gives the soft shadows, mirrored ceiling panels give the shine.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from draw_tools import blur, ramp

SIZE = 120.0  # work-area px, the side of the picture
FINE = 1920  # samples along a side while drawing
PER_PX = FINE / SIZE  # samples per work-area px

# Materials: (albedo, shine, warmth). Warmth tints towards red (+) or blue (-).
ACRYLIC = (0.030, 0.030, 0.2)
BOARD = (0.022, 0.045, -0.5)
RUBBER = (0.020, 0.006, 0.5)
PLASTIC = (0.016, 0.040, 0.0)
PACK = (0.150, 0.050, -0.2)
METAL = (0.240, 0.750, 0.1)
SOLDER = (0.330, 0.500, 0.2)
WIRE = (0.020, 0.060, 0.2)
PRINT = (0.480, 0.000, 0.2)
HOLE = (0.004, 0.000, 0.0)


class Scene:
    """The height map (work-area px) and the materials, sampled FINE x FINE, facing up."""

    def __init__(self) -> None:
        steps = ((np.arange(FINE) + 0.5) / PER_PX - SIZE / 2).astype(np.float32)
        self.x, self.y = np.meshgrid(-steps, steps, indexing="ij")
        self.height = np.zeros((FINE, FINE), np.float32)
        self.material = np.zeros((3, FINE, FINE), np.float32)
        self.solid = np.zeros((FINE, FINE), np.float32)

    def window(self, x: float, y: float, reach: float) -> tuple[slice, slice]:
        """The part of the arrays within `reach` of a point."""
        rows = ((-x + SIZE / 2 + sign * reach) * PER_PX for sign in (-1, 1))
        columns = ((y + SIZE / 2 + sign * reach) * PER_PX for sign in (-1, 1))
        first, last = (int(np.clip(v, 0, FINE)) for v in rows)
        left, right = (int(np.clip(v, 0, FINE)) for v in columns)
        return slice(first, last + 1), slice(left, right + 1)

    def put(self, where, inside, top, material, bevel=0.3) -> None:
        """Lay a part over the window `where`.

        `inside` is the depth within its edge, `top` its height (number or array) and `bevel` the
        radius of its rounded edge.
        """
        cover = np.clip(inside * PER_PX + 0.5, 0, 1)
        slope = np.clip(1 - inside / bevel, 0, 1)
        top = top - bevel * (1 - np.sqrt(1 - slope**2))
        self.height[where] += (top - self.height[where]) * cover
        for layer, value in zip(self.material, material, strict=True):
            layer[where] += (value - layer[where]) * cover
        self.solid[where] = np.maximum(self.solid[where], cover)

    def box(self, x, y, half_x, half_y, top, material, corner=0.3, bevel=0.3) -> None:
        """A box with rounded corners around (x, y)."""
        where = self.window(x, y, max(half_x, half_y) + 1)
        inside = box_depth(self.x[where] - x, self.y[where] - y, half_x, half_y, corner)
        self.put(where, inside, top, material, bevel)

    def disc(self, x, y, radius, top, material, bevel=0.3) -> None:
        """An upright cylinder around (x, y)."""
        where = self.window(x, y, radius + 1)
        inside = radius - np.hypot(self.x[where] - x, self.y[where] - y)
        self.put(where, inside, top, material, bevel)

    def lying_can(self, x, y, half_x, radius, top, material) -> None:
        """A cylinder lying along x."""
        where = self.window(x, y, max(half_x, radius) + 1)
        across = self.y[where] - y
        inside = box_depth(self.x[where] - x, across, half_x, radius, 0.4)
        round_top = top - radius + np.sqrt(np.clip(radius**2 - across**2, 0, None))
        self.put(where, inside, round_top, material, 0.6)

    def screw(self, x, y, top, turn=0.4, radius=2.0) -> None:
        """A round-headed screw with a cross slot, on its washer."""
        self.disc(x, y, radius * 1.3, top + 0.25, METAL, 0.2)
        self.disc(x, y, radius, top + 1.1, METAL, 0.9)
        where = self.window(x, y, radius)
        dx, dy = self.x[where] - x, self.y[where] - y
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        long, thin = 0.62 * radius, 0.17 * radius
        slot = np.minimum(long - abs(along), thin - abs(across))
        slot = np.maximum(slot, np.minimum(long - abs(across), thin - abs(along)))
        self.put(where, slot, top + 0.4, HOLE, 0.1)

    def wire(self, points, top, radius=0.9) -> None:
        """A cable through control points (x, y), smoothed by cutting corners."""
        line = np.array(points, float)
        for _ in range(4):
            near, far = line[:-1], line[1:]
            cut = np.stack([0.75 * near + 0.25 * far, 0.25 * near + 0.75 * far], 1).reshape(-1, 2)
            line = np.concatenate([line[:1], cut, line[-1:]])
        middle = line.mean(0)
        where = self.window(*middle, abs(line - middle).max() + 2)
        away = np.full(self.x[where].shape, 99.0, np.float32)
        for (x0, y0), (x1, y1) in pairwise(line):
            dx, dy = self.x[where] - x0, self.y[where] - y0
            span = max((x1 - x0) ** 2 + (y1 - y0) ** 2, 1e-9)
            t = np.clip((dx * (x1 - x0) + dy * (y1 - y0)) / span, 0, 1)
            away = np.minimum(away, np.hypot(dx - t * (x1 - x0), dy - t * (y1 - y0)))
        self.put(where, radius - away, top, WIRE, radius)


def box_depth(dx, dy, half_x, half_y, corner):
    """Depth inside a box with rounded corners, negative outside."""
    out_x, out_y = abs(dx) - half_x + corner, abs(dy) - half_y + corner
    outside = np.hypot(np.clip(out_x, 0, None), np.clip(out_y, 0, None))
    return corner - outside - np.minimum(np.maximum(out_x, out_y), 0)


def light(scene: Scene) -> np.ndarray:
    """Levels (0 to 255, grey with a faint tint) of the parts under the ceiling's light panels."""
    height = blur(scene.height, 0.8)
    down, right = np.gradient(height, 1 / PER_PX)
    # A nearly straight view never mirrors walls: slopes are softened before the mirror.
    steep = 1 / np.sqrt(1 + down**2 + right**2)
    occlusion = np.zeros_like(height)
    for reach, weight in ((0.7, 0.16), (1.8, 0.26), (4.5, 0.30)):
        above = blur(height, reach * PER_PX) - height
        occlusion += weight * np.clip(above / (1.1 * reach), 0, 1.3)
    sky = np.clip(1 - occlusion, 0.12, 1) * (0.45 + 0.55 * steep)
    sky *= 1 - 0.10 * np.tanh(0.8 * (right - down))
    mirror_right, mirror_down = -2 * right * steep**2, -2 * down * steep**2
    shine = 0.22 + 0.25 * ramp(np.hypot(mirror_right, mirror_down), 1.1, 0.2)
    for panel_right, panel_down in ((0.45, 0.2), (-0.45, 0.2), (0.45, -0.45), (-0.45, -0.45)):
        away = ((mirror_right - panel_right) / 0.26) ** 2 + ((mirror_down - panel_down) / 0.20) ** 2
        shine += 1.0 * np.exp(-away)
    albedo, gloss, warmth = scene.material
    linear = albedo * sky + gloss * shine * np.clip(1 - 0.8 * occlusion, 0.1, 1) * 0.62
    grey = 255 * np.clip(linear, 0, 1) ** (1 / 2.2)
    grey = np.minimum(grey, 232 + 0.1 * (grey - 232))
    tint = np.stack([0.022 * warmth, 0.004 * warmth, -0.026 * warmth], -1)
    return grey[..., None] * (1 + tint)
