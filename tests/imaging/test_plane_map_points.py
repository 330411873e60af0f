import numpy as np
import pytest

from robsim.imaging import PlaneMap

pytestmark = pytest.mark.kernels

SQUARE = [(0, 0), (100, 0), (100, 100), (0, 100)]


def test_four_corners_that_are_themselves_give_the_identity():
    matrix = PlaneMap.from_points(SQUARE, SQUARE).matrix
    np.testing.assert_allclose(matrix / matrix[2, 2], np.eye(3), atol=1e-12)


def test_a_homography_is_found_again(rng):
    for _ in range(50):
        wanted = PlaneMap(np.eye(3) + rng.uniform(-1, 1, (3, 3)) * [[0.3], [0.3], [2e-4]])
        seen = np.multiply([(30, 20), (610, 25), (580, 470), (40, 450)], rng.uniform(0.9, 1.1))
        found = PlaneMap.from_points(seen, wanted.to_world(seen))
        pixels = rng.uniform(0, 480, (20, 2))
        np.testing.assert_allclose(found.to_world(pixels), wanted.to_world(pixels), atol=1e-8)


def test_a_table_seen_at_an_angle():
    # a trapezium: the diagonals meet in the picture where they meet on the table
    plane_map = PlaneMap.from_points([(100, 0), (300, 0), (400, 300), (0, 300)], SQUARE)
    np.testing.assert_allclose(plane_map.to_world((200, 100)), (50, 50), atol=1e-9)
    np.testing.assert_allclose(plane_map.to_pixel((0, 100)), (0, 300), atol=1e-9)


def test_a_point_within_the_triangle_of_the_others():
    seen = [(0, 0), (100, 0), (0, 100), (30, 30)]
    positions = [(5, 5), (205, 5), (5, 205), (65, 65)]
    np.testing.assert_allclose(PlaneMap.from_points(seen, positions).to_world(seen), positions)


@pytest.mark.parametrize("shift", [1, 2, 3])
def test_a_turned_camera(shift):
    plane_map = PlaneMap.from_points(SQUARE, np.roll(SQUARE, shift, axis=0))
    np.testing.assert_allclose(plane_map.to_world((50, 50)), (50, 50), atol=1e-9)


@pytest.mark.parametrize(
    "order",
    [(3, 2, 1, 0), (0, 3, 2, 1), (1, 0, 2, 3), (0, 2, 1, 3)],
    ids=["backwards", "mirrored", "first two swapped", "middle two swapped"],
)
def test_another_order_of_the_points(order):
    with pytest.raises(ValueError, match=r"the same order.*go round in another order"):
        PlaneMap.from_points(SQUARE, [SQUARE[i] for i in order])


@pytest.mark.parametrize("fourth", [(50, 0), (200, 0), (0, 0), (50, 0.01)])
def test_three_points_on_a_line(fourth):
    bad = [(0, 0), (100, 0), (100, 100), fourth]
    with pytest.raises(ValueError, match="pixels must not have three points on a line"):
        PlaneMap.from_points(bad, SQUARE)
    with pytest.raises(ValueError, match="positions must not have three points on a line"):
        PlaneMap.from_points(SQUARE, bad)


@pytest.mark.parametrize(
    "points",
    [SQUARE[:3], [*SQUARE, (5, 5)], [(1, 2, 3)] * 4, "abc", [1, 2], None, [(0, 0), (1,)]],
)
def test_other_shapes(points):
    with pytest.raises((TypeError, ValueError), match=r"pixels must be four points.*\(4, 2\), got"):
        PlaneMap.from_points(points, SQUARE)


def test_points_that_are_not_finite():
    with pytest.raises(ValueError, match="positions must be four points, finite"):
        PlaneMap.from_points(SQUARE, [*SQUARE[:3], (np.nan, 1)])
