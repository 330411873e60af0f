"""Frames of images in OpenCV's order, and what notices one that was taken for RGB."""

import numpy as np
import pytest

import robsim
from robsim.imaging import PlaneMap

OPTIONS = {"resolution": (480, 480), "seed": 1, "robot": "lab"}


def test_from_bgr_exchanges_red_and_blue(rng):
    image = rng.integers(0, 256, (3, 4, 3), dtype=np.uint8)
    plane_map = PlaneMap.scaled((4, 3), (40, 30))
    frame = robsim.Frame.from_bgr(image, t=2.5, index=7, plane_map=plane_map)
    np.testing.assert_array_equal(frame.image, image[..., ::-1])
    assert (frame.t, frame.index) == (2.5, 7)
    np.testing.assert_array_equal(frame.plane_map.matrix, plane_map.matrix)
    wide = np.zeros((3, 8, 3), np.uint8)[:, :4]
    assert robsim.Frame.from_bgr(wide).image.shape == (3, 4, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"image": np.zeros((3, 4), np.uint8)}, "image must"),
        ({"image": np.zeros((3, 4, 3))}, "image must"),
        ({"t": np.nan}, "t must be finite"),
        ({"index": -1}, "index must be at least 0"),
    ],
)
def test_what_from_bgr_refuses(options, message):
    given = {"image": np.zeros((3, 4, 3), np.uint8)} | options
    with pytest.raises((TypeError, ValueError), match=message):
        robsim.Frame.from_bgr(**given)


def test_a_bgr_frame_faces_backwards():
    frame = robsim.Simulation(start=(700, 500, 0.5), **OPTIONS).frame
    wrong = robsim.Frame(np.ascontiguousarray(frame.image[..., ::-1]), plane_map=frame.plane_map)
    right = robsim.Frame.from_bgr(wrong.image, plane_map=frame.plane_map)
    experiment = robsim.Experiment([right, wrong], robot="lab")
    turned = experiment.step().measurement.pose - experiment.step().measurement.pose
    assert abs(turned[2]) == pytest.approx(np.pi, abs=0.1)
