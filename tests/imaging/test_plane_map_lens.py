"""Plane maps through a lens, on the floor and above it, against OpenCV's projection."""

import copy
import pickle

import numpy as np
import pytest

from robsim.vision import Intrinsics, PlaneMap
from scenes import TiltedCamera

pytest.importorskip("cv2")

LENS = (-0.15, 0.04, 0.002, -0.001, 0.003)
CAMERA = TiltedCamera((1280, 960), 1100, LENS)
FLOOR = CAMERA.floor_map()
PLACES = np.stack(np.meshgrid(*2 * [np.linspace(0, 1199, 7)]), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("height", [0, 80, -30])
def test_places_at_a_height_are_where_opencv_projects_them(height):
    plane_map = FLOOR.at_height(height) if height else FLOOR
    seen = CAMERA.pixels(PLACES, height)
    np.testing.assert_allclose(plane_map.to_world(seen), PLACES, atol=1e-7)
    np.testing.assert_allclose(plane_map.to_pixel(PLACES), seen, atol=1e-7)
    if height:  # the map of the floor is far off
        off = np.linalg.norm(FLOOR.to_world(seen) - PLACES, axis=1)
        assert off.min() > 0.1 * abs(height)


def test_many_points_are_fitted_through_the_lens(rng):
    marks = rng.uniform(0, 1199, (30, 2))
    seen = CAMERA.pixels(marks) + rng.normal(0, 0.1, (30, 2))
    plane_map = PlaneMap.from_points(seen, marks, CAMERA.intrinsics)
    off = plane_map.at_height(80).to_world(CAMERA.pixels(PLACES, 80)) - PLACES
    assert np.linalg.norm(off, axis=1).max() < 0.5


@pytest.mark.parametrize("turn", [1, 2])
def test_up_is_towards_the_camera_however_it_is_turned(turn):
    marks = [(0, 0), (1199, 0), (1199, 1199), (0, 1199)]
    seen = CAMERA.pixels(marks)
    # The same camera over a floor whose axes point elsewhere.
    plane_map = PlaneMap.from_points(seen, np.roll(marks, turn, axis=0), CAMERA.intrinsics)
    top = plane_map.at_height(80).to_world(CAMERA.pixels(marks, 80))
    np.testing.assert_allclose(top, np.roll(marks, turn, axis=0), atol=1e-7)


def test_where_the_lens_shows_nothing():
    fold = PlaneMap(
        np.eye(3), Intrinsics([[300, 0, 320], [0, 300, 240], [0, 0, 1]], (-0.3,) + 4 * (0,))
    )
    assert np.isfinite(fold.to_world((400, 300))).all()
    assert np.isnan(fold.to_world((639, 479))).all()
    assert np.isnan(fold.to_pixel((2000, 240))).all()
    pixels = [(300, 200), (400, 200), (639, 479), (300, 300)]
    with pytest.raises(ValueError, match=r"pixels.*\(639, 479\)"):
        PlaneMap.from_points(pixels, pixels, fold.intrinsics)


def test_values():
    for plane_map in (FLOOR, PlaneMap(intrinsics=CAMERA.intrinsics), PlaneMap(FLOOR.matrix)):
        for other in (
            PlaneMap(plane_map.matrix, plane_map.intrinsics),
            pickle.loads(pickle.dumps(plane_map)),
            copy.copy(plane_map),
            eval(repr(plane_map), {"PlaneMap": PlaneMap, "Intrinsics": Intrinsics}),
        ):
            assert other == plane_map
            assert hash(other) == hash(plane_map)
        assert PlaneMap(FLOOR.matrix) != FLOOR
    assert FLOOR.intrinsics == CAMERA.intrinsics
    assert PlaneMap().intrinsics is None
    assert repr(PlaneMap()) == "PlaneMap()"


def test_heights_that_no_map_knows():
    with pytest.raises(ValueError, match="intrinsics"):
        PlaneMap(FLOOR.matrix).at_height(80)
    assert FLOOR.at_height(1558) != FLOOR
    for height in (1559, 1600, float("nan")):  # the camera is 1558.8 px above the floor
        with pytest.raises(ValueError, match="height"):
            FLOOR.at_height(height)
