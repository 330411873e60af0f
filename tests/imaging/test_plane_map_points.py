import numpy as np
import pytest

from robsim.vision import PlaneMap

pytestmark = pytest.mark.kernels

SQUARE = [(0, 0), (100, 0), (100, 100), (0, 100)]


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


def test_another_order_of_the_points():
    # backwards, mirrored, the first two swapped, the middle two swapped
    for order in ((3, 2, 1, 0), (0, 3, 2, 1), (1, 0, 2, 3), (0, 2, 1, 3)):
        refused(SQUARE, [SQUARE[i] for i in order], "order")


def test_three_points_on_a_line():
    for fourth in ((50, 0), (0, 0), (50, 0.01)):
        bad = [(0, 0), (100, 0), (100, 100), fourth]
        refused(bad, SQUARE, "^pixels.*line")
        refused(SQUARE, bad, "^positions.*line")


TABLE = PlaneMap([[1.9, 0.3, -120], [-0.1, 2.4, -60], [1e-4, 5e-4, 1]])
GRID = np.array([(u, v) for u in (40, 240, 440, 600) for v in (30, 200, 450)], float)


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


def test_another_order_of_many_points():
    positions = TABLE.to_world(GRID)
    refused(GRID, np.roll(positions, 5, axis=0), "order")
    refused(GRID, positions * (-1, 1), "order")
    positions[[0, 11]] = positions[[11, 0]]
    refused(GRID, positions, "order")


def test_points_that_do_not_determine_the_map():
    line = np.array([(0, 0), (10, 5), (20, 10), (40, 20), (60, 30), (10, 90)], float)
    refused(line, line, "line")
    refused(*[[(0, 0), (0, 0), (9, 0), (9, 0), (0, 9)]] * 2, "different points")
    refused(GRID[:5], [(0, 0)] * 5, "positions")
