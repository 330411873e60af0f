"""Plane maps of flat pictures; what is no homography and no point is refused."""

import numpy as np

from refusals import INF, NAN, refuses
from robsim.vision import PlaneMap


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
