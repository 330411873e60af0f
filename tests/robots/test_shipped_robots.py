import numpy as np
import pytest

import robsim
from robsim.robots._lookup import shipped_robots
from scenes import errors_of, poses_within, renderer

pytestmark = pytest.mark.long

NAMES = list(shipped_robots())
OTHERS = [name for name in NAMES if name != "lab"]
CAMERA = (600, 600)


def drive(robot, *, steps=60, **options):
    sim = robsim.Simulation(robot=robot, measure=True, control=robsim.DriveAround(), **options)
    return sim.run(steps)


def inside(polygon, right, down):
    """Even-odd rule, for arrays of places."""
    odd = np.zeros(np.shape(right), bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if ay != by:
            odd ^= ((ay > down) != (by > down)) & (right < ax + (down - ay) * (bx - ax) / (by - ay))
    return odd


def test_they_ship():
    assert NAMES == ["lab", "robot2", "sheep"]


# --- the definitions


@pytest.mark.parametrize("name", NAMES)
def test_the_definition_fits_its_folder(name):
    robot = robsim.load_robot(name)
    assert robot.name == name
    assert (shipped_robots()[name] / "robot.png").stat().st_size < 250_000


@pytest.mark.parametrize("name", NAMES)
def test_the_outline_holds_the_robot_and_little_more(name):
    robot = robsim.load_robot(name)
    down, right = np.indices(robot.image.shape[:2])
    within = inside(robot.outline, right, down)
    solid = robot.image[..., 3] > 230
    assert (solid & ~within).sum() <= 0.002 * solid.sum()
    assert within.sum() < 1.15 * solid.sum()


@pytest.mark.parametrize("name", NAMES)
def test_the_markers_lie_on_the_robot(name):
    robot = robsim.load_robot(name)
    for polygon in robot.markers.values():
        assert inside(robot.outline, *polygon.T).all()
        down, right = np.indices(robot.image.shape[:2])
        patch = inside(polygon, right, down)
        assert (robot.image[patch, 3] > 230).all()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("light", [1.0, 0.8])
@pytest.mark.parametrize("color", ["red", "blue"])
def test_vision_sees_one_blob_where_the_polygon_is(name, light, color):
    robot = robsim.load_robot(name)
    x = 300 if light == 1 else 1000
    frame = renderer(robot=robot).render([x, 600, 0])
    blobs = robsim.find_blobs(frame, robsim.load_colors(), minimum_area=1)[color]
    near = [blob for blob in blobs if np.hypot(*(blob.centroid - (x, 600))) < robot.radius]
    assert len(near) == 1
    markers = robot.marker_layout()
    (role,) = (role for role in markers.roles if markers.colors[role] == color)
    place = near[0].centroid - (x, 600)
    np.testing.assert_allclose(place, markers.positions[role], atol=0.3)
    # Limits that hold in noise take in a third of a pixel of the marker's blurred rim.
    assert near[0].area == pytest.approx(markers.areas[role], rel=0.08)


# --- found


# Where red and blue touch, as on robot2, smoothing moves the border between them.
@pytest.mark.parametrize(
    ("name", "smoothing", "most"),
    [
        *((name, 1, 0.3) for name in NAMES),
        ("lab", None, 0.3),
        ("sheep", None, 0.3),
        ("robot2", None, 1),
    ],
)
def test_a_drive_is_tracked(name, smoothing, most):
    trace = drive(
        name,
        headings=None,
        boundary="unlimited",
        resolution=CAMERA,
        seed=3,
        smoothing=smoothing,
    )
    tracking = trace.tracking()
    assert (tracking.seen, tracking.false_poses) == (len(trace), 0)
    assert tracking.rmse_xy < most
    assert tracking.rmse_heading_deg < 0.4


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("noise", [None, robsim.GaussianNoise(5)])
def test_the_36_headings_are_found(name, noise):
    trace = drive(name, noise=noise, seed=4, steps=30)
    tracking = trace.tracking()
    assert (tracking.seen, tracking.false_poses) == (len(trace), 0)


@pytest.mark.parametrize("name", NAMES)
def test_found_anywhere_at_any_heading(name, rng):
    robot = robsim.load_robot(name)
    poses = poses_within(rng, 60, margin=robot.radius + 5)
    errors = errors_of(renderer(robot=robot), poses, markers=robot.marker_layout())
    assert np.isfinite(errors).all()
    # across the edge of the shadow, too
    assert np.hypot(errors[:, 0], errors[:, 1]).max() < 0.8
    assert np.abs(errors[:, 2]).max() < np.deg2rad(0.8)


# --- not taken for another


@pytest.mark.parametrize("name", OTHERS)
def test_the_lab_robots_locator_never_finds_it(name):
    for options in ({"headings": None}, {"noise": robsim.GaussianNoise(5)}):
        trace = drive(
            name, markers="lab", boundary="unlimited", resolution=CAMERA, seed=5, **options
        )
        assert trace.tracking().seen == 0
        for centroids in trace.blobs.values():
            assert np.isfinite(centroids[:, 0]).all()


@pytest.mark.parametrize("name", OTHERS)
def test_it_is_far_from_the_lab_robot(name):
    lab, other = robsim.load_robot("lab").marker_layout(), robsim.load_robot(name).marker_layout()
    assert abs(other.distance / lab.distance - 1) > 2 * lab.distance_tolerance
