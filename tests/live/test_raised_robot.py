"""A robot that stands above the floor, before an oblique camera with a lens: where it is found."""

import numpy as np
import pytest

import robsim
from python_devices import PATIENT
from robsim import _core
from robsim.lab import Lens, SimulatedLab
from robsim.vision import PlaneMap, detect
from scenes import TiltedCamera
from sizes import thorough

pytestmark = pytest.mark.long

pytest.importorskip("cv2")

HEIGHT = 80  # work-area px
DISTORTION = 0.04  # in the corners
AREA = (1200, 1200)
CORNERS = [(0, 0), (1199, 0), (1199, 1199), (0, 1199)]
ROBOT = robsim.load_robot()
COLORS = robsim.load_colors()


def camera_of(size=(1280, 960), focal=900, away=1600, distortion=DISTORTION):
    corner = np.hypot(*size) / 2 / focal
    return TiltedCamera(size, focal, (-distortion / corner**2, 0, 0, 0, 0), tilt=30, away=away)


def lab_of(camera, start=(600, 600, 0.0), height=HEIGHT, **options):
    scenario = robsim.Scenario(
        area=AREA, resolution=camera.size, headings=None, start=start, robot=ROBOT, seed=1
    )
    options = {"plane_map": camera.floor_map(), "robot_height": height} | options
    return SimulatedLab(scenario, **options)


def located(image, plane_map):
    frame = robsim.Frame(image, plane_map=plane_map)
    layout = ROBOT.marker_layout()
    blobs = robsim.find_blobs(frame, COLORS, markers=layout)
    return detect(blobs, layout, plane_map=plane_map, image=frame).measurement


def errors(camera, side, plane_maps):
    """How far off a robot all over the floor is found (N, 2), by each of some maps."""
    rng = np.random.default_rng(1)
    with lab_of(camera) as lab:
        lab._open_device()  # the world has started
        scene = lab._world.scene
        nowhere = (-5000, -5000, 0)
        floor = lab._warp.apply(robsim.simulation.Renderer(scene).render(nowhere))
        robot = _core.RaisedRobot(scene, lab._top)
        places = np.stack(np.meshgrid(*2 * [np.linspace(70, 1129, side)]), axis=-1).reshape(-1, 2)
        poses = np.c_[places + rng.uniform(-2, 2, places.shape), rng.uniform(-3, 3, side**2)]
        found = []
        for pose in poses:
            image = robot.drawn(floor, pose)
            found.append([located(image, one).pose[:2] - pose[:2] for one in plane_maps])
    return np.swapaxes(found, 0, 1)


def rms(off):
    return np.sqrt((off**2).sum(axis=-1).mean())


@pytest.mark.parametrize(
    "options",
    [
        {},
        pytest.param({"focal": 1300, "away": 2300}, marks=pytest.mark.slow),
        pytest.param({"focal": 600, "away": 1150}, marks=pytest.mark.slow),
        pytest.param({"distortion": -DISTORTION}, marks=pytest.mark.slow),
    ],
    ids=["usual", "far", "near", "pincushion"],
)
def test_a_robot_all_over_the_floor_is_found_where_it_is(options):
    camera = camera_of(**options)
    floor = camera.floor_map()
    plain = PlaneMap.from_points(camera.pixels(CORNERS), CORNERS)
    maps = floor.at_height(HEIGHT), floor, plain
    side = thorough(24, 6)
    exact, without_height, without_both = map(rms, errors(camera, side, maps))
    assert exact < 0.3
    assert without_height > 30
    assert without_both > 30


@pytest.mark.parametrize("height", [0, HEIGHT])
def test_the_lab_shows_the_robot_at_its_height(height):
    camera = camera_of((640, 480), 450)
    pose = (250, 900, 1.0)
    plane_map = camera.floor_map().at_height(height)
    with lab_of(camera, pose, height) as lab:
        with robsim.Camera(lab, plane_map=plane_map, **PATIENT) as live:
            frame = next(iter(live))
        true = lab.truth.pose_of(frame)
    assert np.hypot(*(located(frame.image, plane_map).pose[:2] - true[:2])) < 0.8
    # The floor stays where it is: its corner, which is grey outside.
    u, v = np.rint(camera.pixels([(-12, -12), (12, 12)])).astype(int).T
    outside, inside = frame.image[v, u]
    assert (outside == 128).all()
    assert (inside != 128).any()


def test_what_cannot_be_is_refused():
    camera = camera_of((640, 480), 450)
    for options, words in (
        ({"plane_map": None}, "robot_height.*intrinsics"),
        ({"height": 2000}, "robot_height.*below the camera"),
        ({"height": -1}, "robot_height"),
        ({"lens": Lens(-0.04)}, "lens"),
    ):
        with pytest.raises(ValueError, match=words):
            lab_of(camera, **options)
