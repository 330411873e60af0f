import numpy as np
import pytest

import robsim


def test_a_camera_as_large_as_the_area_is_the_identity():
    plane_map = robsim.imaging.PlaneMap.scaled((1200, 1200), (1200, 1200))
    np.testing.assert_array_equal(plane_map.matrix, np.eye(3))


def test_pixel_centres_of_a_smaller_camera():
    # x = (u + 1/2) W/w - 1/2: pixel 0 of 480 stands for work-area pixels 0 .. 2.5
    plane_map = robsim.imaging.PlaneMap.scaled((480, 240), (1200, 1200))
    np.testing.assert_allclose(plane_map.to_world((0, 0)), (0.75, 2.0))
    np.testing.assert_allclose(plane_map.to_world((479, 239)), (1198.25, 1197.0))
    np.testing.assert_allclose(plane_map.to_pixel((-0.5, -0.5)), (-0.5, -0.5))


def test_there_and_back_through_a_homography(rng):
    plane_map = robsim.imaging.PlaneMap(np.eye(3) + rng.uniform(-1e-4, 1e-4, (3, 3)))
    pixels = rng.uniform(0, 640, (100, 2))
    places = plane_map.to_world(pixels)
    assert places.shape == (100, 2)
    assert np.abs(places - pixels).max() > 1e-3
    np.testing.assert_allclose(plane_map.to_pixel(places), pixels, atol=1e-8)


@pytest.mark.parametrize("matrix", [np.zeros((3, 3)), np.full((3, 3), np.nan), np.eye(2), "abc"])
def test_a_matrix_without_inverse_is_refused(matrix):
    with pytest.raises((ValueError, TypeError), match="matrix"):
        robsim.imaging.PlaneMap(matrix)
