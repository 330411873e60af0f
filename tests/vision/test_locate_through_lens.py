"""Where markers are found by the map of their height, through a lens."""

import math

import numpy as np
import pytest

import robsim
from robsim.vision import Blob, MarkerLayout, detect
from scenes import TiltedCamera

pytest.importorskip("cv2")

HEIGHT = 80
CAMERA = TiltedCamera((1280, 960), 1000, (-0.1, 0.02, 0.001, -0.001, 0), away=1600)
MAP = CAMERA.floor_map().at_height(HEIGHT)
RED, BLUE = (20.0, 55.0), (-10.0, -60.0)
AXES = np.stack([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 400, endpoint=False)])


def placed(point, pose):
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return pose[:2] + np.array([[c, -s], [s, c]]) @ point


def seen_disc(color, centre, radius):
    """The blob of a disc above the floor: area and centroid of what OpenCV projects it to."""
    u, v = CAMERA.pixels(centre + radius * AXES, HEIGHT).T
    cross = u * np.roll(v, -1) - np.roll(u, -1) * v
    area = cross.sum() / 2
    centroid = [((one + np.roll(one, -1)) * cross).sum() / (6 * area) for one in (u, v)]
    box = [int(one) for one in (u.min(), v.min(), u.max(), v.max())]
    return Blob(color, area=round(abs(area)), centroid=centroid, bounding_box=tuple(box))


def located(pose, radius, plane_map=MAP, tolerance=1.03):
    area = math.pi * radius**2
    markers = MarkerLayout.from_positions(
        {"right": RED, "left": BLUE}, areas={"right": area, "left": area}, area_tolerance=tolerance
    )
    blobs = {
        name: [seen_disc(name, placed(point, pose), radius)]
        for name, point in (("red", RED), ("blue", BLUE))
    }
    return detect(blobs, markers, plane_map=plane_map)


@pytest.mark.parametrize("radius", [10, 50])
@pytest.mark.parametrize("pose", [(150, 130, 0.3), (1050, 140, 2.5), (600, 1080, -1.8)])
def test_large_markers_are_not_drawn_to_the_nearer_side(pose, radius):
    found = located(pose, radius)
    assert np.hypot(*(found.measurement.pose[:2] - pose[:2])) < 0.02
    assert abs(found.measurement.pose[2] - pose[2]) < 1e-4
    # The mere middle of what is seen is off by what a large marker makes of the perspective.
    middles = [MAP.to_world(blob.centroid) for blob in found.seen.values()]
    corners = [placed(point, pose) for point in (RED, BLUE)]
    off = np.linalg.norm(np.subtract(middles, corners).mean(axis=0))
    assert off > 0.3 if radius == 50 else off < 0.05


def test_what_lies_where_the_lens_shows_nothing_is_no_marker():
    folding = robsim.vision.Intrinsics(CAMERA.matrix, (-2, 0, 0, 0, 0))
    place = {"area": 400, "centroid": (1200, 900), "bounding_box": (1190, 890, 1210, 910)}
    blobs = {color: [Blob(color, **place)] for color in ("red", "blue")}
    plane_map = robsim.vision.PlaneMap(np.eye(3), folding)
    assert np.isnan(plane_map.to_world((1200, 900))).all()
    markers = MarkerLayout.from_positions({"right": RED, "left": BLUE})
    assert detect(blobs, markers, plane_map=plane_map).measurement is None
