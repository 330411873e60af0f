"""Plane maps: flat pictures, points, and the lens of a camera."""

import numpy as np
import pytest

from refusals import INF, NAN, refuses
from robsim.vision import Intrinsics, PlaneMap

# --- flat pictures


def test_pixel_centres_of_a_smaller_camera():
    # x = (u + 1/2) W/w - 1/2: pixel 0 of 480 stands for work-area pixels 0 .. 2.5
    plane_map = PlaneMap.scaled((480, 240), (1200, 1200))
    np.testing.assert_allclose(plane_map.to_world((0, 0)), (0.75, 2.0))
    np.testing.assert_allclose(plane_map.to_world((479, 239)), (1198.25, 1197.0))
    np.testing.assert_allclose(plane_map.to_pixel((-0.5, -0.5)), (-0.5, -0.5))


def test_there_and_back_through_a_homography(rng):
    plane_map = PlaneMap(np.eye(3) + rng.uniform(-1e-4, 1e-4, (3, 3)))
    pixels = rng.uniform(0, 640, (100, 2))
    places = plane_map.to_world(pixels)
    assert places.shape == (100, 2)
    assert np.abs(places - pixels).max() > 1e-3
    np.testing.assert_allclose(plane_map.to_pixel(places), pixels, atol=1e-8)


def test_a_homography_is_the_same_times_any_number():
    for factor in (1e-5, -2, 1e200):
        np.testing.assert_allclose(PlaneMap(np.eye(3) * factor).to_world((3, 4)), (3, 4))


def test_what_is_no_map_and_no_point():
    for matrix in (
        *(np.eye(2), np.zeros((1, 3, 3)), np.ones((3, 3)), np.diag([1, 1, 0])),
        *(np.zeros((3, 3)), np.eye(3) * NAN, np.full((3, 3), INF)),
    ):
        refuses("matrix", PlaneMap, matrix)
    for size in ((0, 1), (1, -1), (1.5, 1), (2**31, 1)):
        refuses("resolution", PlaneMap.scaled, size, (1, 1))
    for area in ((0, 1), (INF, 1), (1e-9, 1e-9)):
        refuses("area", PlaneMap.scaled, (1000, 1000), area)
    for name, call in (("pixels", PlaneMap().to_world), ("positions", PlaneMap().to_pixel)):
        for points in ((10**400, 0), [NAN, 1], [[INF, 1]]):
            refuses(name, call, points)
        for shape in ((2,), (0, 2), (4, 2)):
            assert call(np.zeros(shape)).shape == shape
        for shape in ((1,), (3,), (2, 3), (2, 2, 2), (2, 0)):
            refuses(name, call, np.zeros(shape))


# --- points


SQUARE = [(0, 0), (100, 0), (100, 100), (0, 100)]


@pytest.mark.kernels
def test_a_homography_is_found_again(rng):
    for _ in range(20):
        wanted = PlaneMap(np.eye(3) + rng.uniform(-1, 1, (3, 3)) * [[0.3], [0.3], [2e-4]])
        seen = np.multiply([(30, 20), (610, 25), (580, 470), (40, 450)], rng.uniform(0.9, 1.1))
        found = PlaneMap.from_points(seen, wanted.to_world(seen))
        pixels = rng.uniform(0, 480, (20, 2))
        np.testing.assert_allclose(found.to_world(pixels), wanted.to_world(pixels), atol=1e-8)


def refused(pixels, positions, words):
    with pytest.raises((TypeError, ValueError), match=words):
        PlaneMap.from_points(pixels, positions)


@pytest.mark.kernels
def test_another_order_of_the_points():
    # backwards, mirrored, the first two swapped, the middle two swapped
    for order in ((3, 2, 1, 0), (0, 3, 2, 1), (1, 0, 2, 3), (0, 2, 1, 3)):
        refused(SQUARE, [SQUARE[i] for i in order], "order")


@pytest.mark.kernels
def test_three_points_on_a_line():
    for fourth in ((50, 0), (0, 0), (50, 0.01)):
        bad = [(0, 0), (100, 0), (100, 100), fourth]
        refused(bad, SQUARE, "^pixels.*line")
        refused(SQUARE, bad, "^positions.*line")


TABLE = PlaneMap([[1.9, 0.3, -120], [-0.1, 2.4, -60], [1e-4, 5e-4, 1]])
GRID = np.array([(u, v) for u in (40, 240, 440, 600) for v in (30, 200, 450)], float)


@pytest.mark.kernels
def test_the_squared_distances_are_least(rng):
    positions = TABLE.to_world(GRID) + rng.normal(0, 3, GRID.shape)
    best = PlaneMap.from_points(GRID, positions)

    def cost(matrix):
        return ((PlaneMap(matrix).to_world(GRID) - positions) ** 2).sum()

    for i, j in np.ndindex(3, 3):
        if (i, j) != (2, 2):
            for factor in (1 - 1e-4, 1 + 1e-4):
                other = best.matrix.copy()
                other[i, j] *= factor
                assert cost(other) > cost(best.matrix)


@pytest.mark.kernels
def test_another_order_of_many_points():
    positions = TABLE.to_world(GRID)
    refused(GRID, np.roll(positions, 5, axis=0), "order")
    refused(GRID, positions * (-1, 1), "order")
    positions[[0, 11]] = positions[[11, 0]]
    refused(GRID, positions, "order")


@pytest.mark.kernels
def test_points_that_do_not_determine_the_map():
    line = np.array([(0, 0), (10, 5), (20, 10), (40, 20), (60, 30), (10, 90)], float)
    refused(line, line, "line")
    refused(*[[(0, 0), (0, 0), (9, 0), (9, 0), (0, 9)]] * 2, "different points")
    refused(GRID[:5], [(0, 0)] * 5, "positions")


# --- intrinsics


SIZE = (1280, 960)
MATRIX = np.array([[1010.0, 0, 636.5], [0, 1000, 482.25], [0, 0, 1]])
LENSES = {
    "barrel": (-0.12, 0, 0, 0, 0),
    "pincushion": (0.2, 0.05, 0, 0, 0),
    "both": (-0.3, 0.12, 0.001, -0.002, -0.02),
    "skewed": (0.05, -0.02, 0.004, 0.003, 0.01),
    "none": (0.0, 0.0, 0.0, 0.0, 0.0),
}


def grid(size=SIZE, n=9):
    sides = (np.linspace(-0.5, side - 0.5, n) for side in size)
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("distortion", LENSES.values(), ids=LENSES)
def test_a_lens_distorts_as_that_of_opencv(distortion):
    cv2 = pytest.importorskip("cv2")
    rays = np.c_[(grid() - MATRIX[:2, 2]) / MATRIX.diagonal()[:2], np.ones(81)]
    expected, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), MATRIX, np.array(distortion))
    found = Intrinsics(MATRIX, distortion).distorted(grid())
    np.testing.assert_allclose(found, expected[:, 0], atol=1e-9)


NO_MATRIX = (
    *(np.eye(2), np.zeros((3, 3)), 2 * np.eye(3), np.diag([0, 1, 1]), np.diag([1, -1, 1])),
    *(MATRIX.T, MATRIX + np.eye(3, k=1), MATRIX + np.diag([INF, 0, 0])),
)


def test_what_is_no_lens():
    for matrix in NO_MATRIX:
        refuses("matrix", Intrinsics, matrix)
    for distortion in ((1, 2, 3, 4), np.zeros((1, 5)), (0, 0, 0, 0, NAN), (0, 0, 0, INF, 0)):
        refuses("distortion", Intrinsics, MATRIX, distortion)
    for call in (Intrinsics(MATRIX).ideal, Intrinsics(MATRIX).distorted):
        for pixels in ((1, 2, 3), (NAN, 1)):
            refuses("pixels", call, pixels)
