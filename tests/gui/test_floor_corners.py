"""Corners and dots that a point is put on."""

import numpy as np
import pytest

from browsers import pixels_of_floor, tiled_floor
from robsim.gui.tools.floor.corners import snapped

SIZE, FINE = 100, 6
AT = np.array((50.3, 48.7))


def picture(dark):
    """A picture of what is dark by its place, from a turn about a point, through a blur."""
    across = (np.arange(SIZE * FINE) + 0.5) / FINE - 0.5
    u, v = np.meshgrid(across - AT[0], across - AT[1])
    x, y = np.cos(0.3) * u + np.sin(0.3) * v, np.cos(0.3) * v - np.sin(0.3) * u
    levels = np.where(dark(x, y), 50.0, 190.0).reshape(SIZE, FINE, SIZE, FINE).mean(axis=(1, 3))
    levels = np.pad(levels, 1, mode="edge")
    levels = (levels[:-2] + 2 * levels[1:-1] + levels[2:]) / 4
    levels = (levels[:, :-2] + 2 * levels[:, 1:-1] + levels[:, 2:]) / 4
    levels += 2 * np.random.default_rng(3).standard_normal(levels.shape)
    return np.repeat(np.clip(np.rint(levels), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


PATTERNS = {
    "joint": lambda x, y: (abs(x) < 1.5) | (abs(y) < 1.5),
    "chessboard": lambda x, y: x * y > 0,
    "corner": lambda x, y: (x > 0) & (y > 0),
    "dot": lambda x, y: np.hypot(x, y) < 4,
}


def test_it_is_found_to_a_tenth_of_a_pixel():
    for dark in PATTERNS.values():
        image = picture(dark)
        for off in ((0, 0), (5, -4), (-6, 3)):
            assert snapped(image, tuple(AT + off), 12) == pytest.approx(tuple(AT), abs=0.1)


def test_nothing_is_found_on_a_plain_floor_on_an_edge_or_out_of_reach():
    for dark in (lambda x, _: x > 1e9, lambda x, _: x > 0):
        assert snapped(picture(dark), (50, 50), 12) is None
    assert snapped(picture(PATTERNS["corner"]), (70, 70), 9) is None


def test_the_edges_of_the_picture_do_no_harm():
    for at in ((-500, 20), (0, 0), (99, 99), (1e6, 1e6)):
        snapped(picture(PATTERNS["joint"]), at, 12)


def test_joints_of_the_tiles_of_the_example():
    places = np.array([(x, y) for x in (300, 900, 2100) for y in (300, 1500, 2100)], float)
    true = pixels_of_floor(places)
    found = [
        snapped(tiled_floor(), tuple(np.rint(pixel) + np.array((2, -2))), 10) for pixel in true
    ]
    off = np.linalg.norm(np.array(found) - true, axis=1)
    assert off.max() < 0.4
    assert np.sqrt((off**2).mean()) < 0.25
