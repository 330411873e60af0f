"""Covariance and misfit of poses where the body's colour hides an edge of a marker."""

import numpy as np
import pytest

import robsim
from foreign_frames import coverage
from robsim.vision import MarkerLayout, PlaneMap

COLORS = robsim.load_colors()
FLOOR, BODY = (170, 165, 160), (70, 70, 70)
MARKERS = {"right": (199, 37, 41), "left": (29, 63, 171)}
APART, BEHIND, SIDE = 43.0, 14.0, 23.2  # work-area px
ANGLES = 2 * np.pi * (np.arange(48) + 0.5) / 48
DISC = SIDE / np.sqrt(np.pi) * np.column_stack((np.cos(ANGLES), np.sin(ANGLES)))
SQUARE = SIDE / 2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def outlines(shape):
    return {
        role: shape + np.array((-BEHIND, side * APART / 2))
        for role, side in (("right", 1), ("left", -1))
    }


def drawn(shape, pose, size, rng, *, noise=0.0, hidden=0.0, blur=True):
    """A frame of a robot with such markers; the front of the right one is hidden, so many px."""
    scale, middle = size / 1200, np.round(np.multiply(pose[:2], size / 1200)) - 40 * size / 480
    width = int(80 * size / 480)
    image = np.full((width, width, 3), FLOOR, float)
    cos, sin = np.cos(pose[2]), np.sin(pose[2])

    def paint(corners, color):
        at = corners @ np.array([(cos, sin), (-sin, cos)]) + pose[:2]
        image[:] += coverage((at + 0.5) * scale - middle, width, width)[..., None] * (color - image)

    paint(48 / SIDE * np.sqrt(np.pi) * DISC, BODY)
    for role, corners in outlines(shape).items():
        seen = corners.copy()
        if role == "right":
            seen[:, 0] = np.minimum(seen[:, 0], seen[:, 0].max() - hidden)
        paint(seen, MARKERS[role])
    if blur:
        for axis in (0, 1):
            image = (np.roll(image, 1, axis) + 2 * image + np.roll(image, -1, axis)) / 4
    if noise:
        image += rng.normal(0, 2.55 * noise, image.shape)
    pixels = np.full((size, size, 3), FLOOR, np.uint8)
    left, top = middle.astype(int)
    pixels[top : top + width, left : left + width] = np.clip(np.rint(image), 0, 255)
    return robsim.Frame(pixels, plane_map=PlaneMap.scaled((size, size), (1200, 1200)))


def measured(shape, size, count, *, turn=np.pi, **options):
    """NEES / 3 and misfit of measurements of poses anywhere: arrays (N,)."""
    rng = np.random.default_rng(3)
    markers = MarkerLayout.from_markers(outlines(shape))
    nees, misfits = [], []
    for _ in range(count):
        axis = rng.integers(4) * np.pi / 2
        pose = np.array((*rng.uniform(400, 800, 2), axis + rng.uniform(-turn, turn)))
        frame = drawn(shape, pose, size, rng, **options)
        blobs = robsim.find_blobs(frame, COLORS, markers=markers)
        found = robsim.locate(blobs, markers, image=frame, colors=COLORS)
        error = robsim.estimation.wrapped_error(found.pose, pose)
        nees.append(robsim.estimation.nees(error, found.covariance) / 3)
        misfits.append(found.misfit)
    return np.ravel(nees), np.array(misfits)


@pytest.mark.parametrize(
    ("shape", "size", "noise", "hidden"),
    [
        (DISC, 480, 10, 6.5),  # a quarter of its width
        (SQUARE, 480, 0, 1.2),
        (SQUARE, 480, 2, 1.2),
        (SQUARE, 480, 2, 2.3),
        (SQUARE, 1200, 2, 0.35),
    ],
)
def test_the_covariance_covers_a_hidden_edge_or_the_misfit_tells_it(shape, size, noise, hidden):
    nees, misfits = measured(shape, size, 16, noise=noise, hidden=hidden)
    assert np.mean(np.where(misfits > 2, 0, nees)) < 2
    assert np.mean(nees) < 3


def test_the_covariance_covers_sharp_edges_along_the_pixels():
    nees, _ = measured(SQUARE, 480, 60, turn=np.deg2rad(1), blur=False)
    # 2.5 % of all headings are that near to an axis: at most 0.5 % of all, of 60 a fifth
    assert np.sum(nees > 3) <= 12
    assert np.mean(nees) < 2


@pytest.mark.parametrize("noise", [2, 10])
@pytest.mark.parametrize("shape", [DISC, SQUARE], ids=["disc", "square"])
def test_nothing_is_told_where_nothing_is_hidden(shape, noise):
    nees, misfits = measured(shape, 480, 20, noise=noise)
    assert np.mean(nees) < 1.6
    assert np.all(misfits < 2)
