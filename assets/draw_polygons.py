"""Polygons around the coloured and the solid parts of a picture.

Points are [right, down] in picture pixels; the centre of the top left pixel is (0, 0).
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
from draw_tools import blur, chroma
from PIL import Image

COLOURS = tomllib.loads(Path(__file__).with_name("colors.toml").read_text(encoding="utf-8"))


def scene_scale(picture: Image.Image, size: float) -> np.ndarray:
    """The picture's RGB as vision gets it at a pixel a work-area px, between the pixels, too."""
    width, height = picture.size
    small = picture.convert("RGB").resize(
        (round(size), round(size * height / width)), Image.Resampling.BOX
    )
    return np.asarray(small.resize((width, height), Image.Resampling.BILINEAR)).astype(float)


def colour_margin(rgb: np.ndarray, name: str) -> np.ndarray:
    """How far each pixel's U and V lie within a colour of the colour file; negative outside."""
    margin = np.full(rgb.shape[:2], np.inf)
    for key, value in zip("uv", chroma(rgb), strict=True):
        low, high = COLOURS[name][key]
        margin = np.minimum(margin, np.minimum(value + 128 - low, high - value - 128))
    return margin


def patch_polygon(picture: Image.Image, size: float, name: str) -> np.ndarray:
    """The polygon of a colour's patch, with the area and the centroid of what vision sees.

    The light is taken half way to the shadow.
    """
    margin = colour_margin(0.9 * scene_scale(picture, size), name)
    polygon = simplify(contour(margin), 0.7)
    down, right = np.nonzero(margin >= 0)
    return moved(polygon, right.size, np.array([right.mean(), down.mean()]))


def outline_polygon(picture: Image.Image) -> np.ndarray:
    """The polygon around the solid parts, a few picture px outside them."""
    solid = np.asarray(picture)[..., 3] > 230
    return simplify(contour(blur(solid, 3.5) - 0.12), 1.8)


def contour(field: np.ndarray) -> np.ndarray:
    """The longest closed line on which a field is 0, linear between its samples."""
    inside = field >= 0
    cells = inside[:-1, :-1].astype(int) + inside[:-1, 1:] + inside[1:, :-1] + inside[1:, 1:]
    following = {}
    for down, right in zip(*np.nonzero((cells > 0) & (cells < 4)), strict=True):
        following.update(cell_lines(inside, int(down), int(right)))
    lines = []
    while following:
        first, edge = following.popitem()
        line = [first]
        while edge != first:
            line.append(edge)
            edge = following.pop(edge, first)
        lines.append(line)
    return np.array([crossing(field, *edge) for edge in max(lines, key=len)])


def cell_lines(inside: np.ndarray, down: int, right: int) -> list[tuple]:
    """The contour's pieces in a cell of four samples: from edge to edge, the inside at its right.

    An edge is a pair of neighbouring samples, the one that lies inside first.
    """
    corners = [(down, right), (down, right + 1), (down + 1, right + 1), (down + 1, right)]
    enter, leave = [], []
    for i in range(4):
        a, b = corners[i - 1], corners[i]
        if inside[a] and not inside[b]:
            leave.append((a, b))
        if inside[b] and not inside[a]:
            enter.append((b, a))
    if len(enter) == 2 and enter[0][0] == leave[0][0]:
        leave.reverse()
    return list(zip(leave, enter, strict=True))


def crossing(field: np.ndarray, a: tuple[int, int], b: tuple[int, int]) -> tuple[float, float]:
    """Where the field is 0 between two samples: (right, down)."""
    part = field[a] / (field[a] - field[b])
    return a[1] + part * (b[1] - a[1]), a[0] + part * (b[0] - a[0])


def simplify(line: np.ndarray, tolerance: float) -> np.ndarray:
    """Fewer points of a closed line; what is left out lies within the tolerance."""
    far = int(np.argmax(np.hypot(*(line - line[0]).T)))
    halves = (line[: far + 1], np.vstack((line[far:], line[:1])))
    return np.vstack([simplify_open(half, tolerance)[:-1] for half in halves])


def simplify_open(line: np.ndarray, tolerance: float) -> np.ndarray:
    """Fewer points of a line between its ends (Douglas and Peucker)."""
    first, last = line[0], line[-1]
    along = (last - first) / max(np.hypot(*(last - first)), 1e-9)
    away = abs((line - first) @ np.array([-along[1], along[0]]))
    worst = int(np.argmax(away))
    if away[worst] <= tolerance:
        return line[[0, -1]]
    parts = simplify_open(line[: worst + 1], tolerance), simplify_open(line[worst:], tolerance)
    return np.vstack((parts[0][:-1], parts[1]))


def area_and_centroid(polygon: np.ndarray) -> tuple[float, np.ndarray]:
    """The polygon's area (px^2) and centroid (right, down)."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
    return abs(cross.sum()) / 2, ((a + b) * cross[:, None]).sum(0) / (3 * cross.sum())


def moved(polygon: np.ndarray, area: float, centroid: np.ndarray) -> np.ndarray:
    """The polygon, moved and scaled to an area and a centroid."""
    old_area, old_centroid = area_and_centroid(polygon)
    return centroid + (polygon - old_centroid) * np.sqrt(area / old_area)
