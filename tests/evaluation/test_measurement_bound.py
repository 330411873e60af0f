"""The least error of a measured pose: tables of an independent computation, and cases by hand."""

import numpy as np
import pytest
from scipy.special import ndtr

import robsim
from robsim.estimation import measurement_bound
from robsim.vision import Frame, PlaneMap

# In the light, away from the edge of the shadow.
POSES = ((310.3, 420.7, 0.4), (560.6, 880.2, -2.1), (205.5, 640.9, 1.9))
NOISES = {"gaussian": robsim.GaussianNoise, "uniform": robsim.UniformNoise}


def shown(size, pose):
    """The lab robot at a pose, seen by a camera of so many px."""
    sim = robsim.Simulation(robot="lab", headings=None, resolution=(size, size), start=pose)
    sim.step()
    return sim.frame, sim.robot


def coverage(size, centre, radius, width):
    """How much of each pixel of a frame a blurred disc covers (h, w)."""
    v, u = np.mgrid[: size[1], : size[0]]
    return ndtr((radius - np.hypot(u - centre[0], v - centre[1])) / width)


def disc(radius, right=0.0):
    """The polygon of a disc, so far to the right of the robot's centre."""
    turns = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    return radius * np.column_stack((np.cos(turns), np.sin(turns))) + np.array((0, right))


def grey_frame(values):
    return Frame(np.repeat(np.rint(values).astype(np.uint8)[..., np.newaxis], 3, axis=2))


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "kind", "percent", "rmse_xy", "rmse_heading_deg"),
    [
        (1200, "gaussian", 10, 0.039, 0.064),
        (1200, "uniform", 40, 0.094, 0.156),
        (480, "gaussian", 40, 0.670, 1.12),
        (480, "uniform", 10, 0.095, 0.159),
    ],
)
def test_the_bound_is_that_of_an_independent_drawing(
    size, kind, percent, rmse_xy, rmse_heading_deg
):
    noise = NOISES[kind](percent)
    bounds = [measurement_bound(*_at(size, pose), noise=noise) for pose in POSES]
    xy, heading = (
        np.sqrt(np.mean([getattr(bound, name) ** 2 for bound in bounds]))
        for name in ("rmse_xy", "rmse_heading_deg")
    )
    assert xy == pytest.approx(rmse_xy, rel=0.05)
    assert heading == pytest.approx(rmse_heading_deg, rel=0.07)


def _at(size, pose):
    frame, robot = shown(size, pose)
    return frame, pose, robot


def test_the_bound_without_noise_is_that_of_rounding():
    bound = measurement_bound(*_at(480, POSES[0]))
    assert bound.rmse_xy == pytest.approx(0.0018, rel=0.08)
    assert bound.title == "Best linear measurement"
    zero = measurement_bound(*_at(480, POSES[0]), noise=robsim.GaussianNoise(0))
    np.testing.assert_array_equal(bound.covariance, zero.covariance)


@pytest.mark.long
def test_two_discs_by_hand():
    width, contrast, radius, apart, sigma = 0.8, 100.0, 15.0, 60.0, 5.1
    covered = sum(coverage((160, 100), (u, 49.5), radius, width) for u in (50.0, 110.0))
    # Headed up: the right of the robot is the right of the picture.
    bound = measurement_bound(
        grey_frame(70 + contrast * covered),
        (80, 49.5, -np.pi / 2),
        [disc(radius, side) for side in (-apart / 2, apart / 2)],
        noise=robsim.GaussianNoise(2),
    )
    # SNR^2 = channels contrast^2/sigma^2 perimeter w/(2 sqrt(pi)), of both
    of_one = 3 * contrast**2 / sigma**2 * 2 * np.pi * radius * width / (2 * np.sqrt(np.pi))
    snr = np.sqrt(2 * of_one)
    assert bound.edge_width == pytest.approx(width, rel=0.02)
    assert bound.signal_to_noise == pytest.approx(snr, rel=0.03)
    # Each tells SNR_1^2/(2 w^2) of x, and as much of y.
    assert bound.rmse_xy == pytest.approx(2 * width / snr, rel=0.03)
    heading = np.sqrt(2) * 2 * width / snr / apart
    assert bound.rmse_heading_deg == pytest.approx(np.rad2deg(heading), rel=0.03)
    np.testing.assert_allclose(bound.covariance[0, 1], 0, atol=1e-3 * bound.covariance[0, 0])


def test_markers_with_corners_have_the_bound_of_what_they_cover():
    """Squares, each pixel's share by the product of two blurred strips: exact."""
    width, side, sigma = 0.8, 9.3, 5.1

    def strip(place, at):
        ends = (place + end * side / 2 - at for end in (1, -1))
        far, near = (ndtr(end / width) for end in ends)
        return far - near

    def drawn(x, y):
        return np.outer(strip(y, np.arange(30)), strip(x, np.arange(30)))

    square = side / 2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    x, y, step = 14.3, 15.1, 1e-3
    bound = measurement_bound(
        grey_frame(70 + 100 * drawn(x, y)),
        (x, y, 0),
        [square, square + 1e-6],
        noise=robsim.GaussianNoise(2),
    )
    slope = 100 * (drawn(x + step, y) - drawn(x - step, y)) / (2 * step)
    # By symmetry nothing else that is unknown counts; six measurements of the same place.
    expected = sigma / np.sqrt(6 * np.square(slope).sum())
    assert np.sqrt(bound.covariance[0, 0]) == pytest.approx(expected, rel=0.01)


@pytest.mark.long
def test_the_best_fit_of_many_noisy_frames_reaches_the_bound(rng):
    """Least squares for place, blur, level and contrast, on noise without clipping."""
    width, radius, sigma, centre = 0.8, 12.0, 10.2, np.array((30.3, 29.6))

    def drawn(place, blur):
        return coverage((60, 60), place, radius, blur).ravel()

    clean = 80 + 90 * drawn(centre, width)
    bound = measurement_bound(
        grey_frame(clean.reshape(60, 60)),
        (*centre, 0),
        [disc(radius), disc(radius, 1e-6)],
        noise=robsim.GaussianNoise(4),
    )
    step = 1e-3
    moves = [(drawn(centre + d, width) - drawn(centre - d, width)) for d in step * np.eye(2)]
    blur = drawn(centre, width + step) - drawn(centre, width - step)
    slopes = np.column_stack((*moves, blur)) * 90 / (2 * step)
    basis = np.column_stack((slopes, np.ones(clean.size), drawn(centre, width)))
    noisy = np.rint(clean + rng.normal(0, sigma, (600, clean.size)))
    errors = (noisy - clean) @ np.linalg.pinv(basis)[:2].T
    rms_of_one_channel = np.sqrt(np.square(errors).sum(axis=1).mean())
    # Two markers of three channels each are six measurements of the same place.
    assert bound.rmse_xy * np.sqrt(6) == pytest.approx(rms_of_one_channel, rel=0.08)


def test_the_bound_is_in_px_of_the_work_area():
    frame, robot = shown(480, POSES[0])
    noise = robsim.GaussianNoise(10)
    bound = measurement_bound(frame, POSES[0], robot, noise=noise)
    polygons = [2 * robot.to_robot_frame(one.polygon) for one in robot.markers.values()]
    large = Frame(frame.image, plane_map=PlaneMap.scaled((480, 480), (2400, 2400)))
    # The origin of both areas is the centre of a px of the area.
    x, y, heading = POSES[0]
    pose = (2 * x + 0.5, 2 * y + 0.5, heading)
    twice = measurement_bound(large, pose, polygons, noise=noise)
    assert twice.rmse_xy == pytest.approx(2 * bound.rmse_xy, rel=2e-3)
    assert twice.rmse_heading_deg == pytest.approx(bound.rmse_heading_deg, rel=2e-3)
    assert twice.signal_to_noise == pytest.approx(bound.signal_to_noise, rel=2e-3)


def test_a_camera_with_fewer_rows_tells_less_of_y():
    frame, robot = shown(480, POSES[0])
    noise = robsim.GaussianNoise(10)
    straight = measurement_bound(frame, POSES[0], robot, noise=noise).covariance
    rows = frame.image.reshape(240, 2, 480, 3).mean(axis=1)
    flat = Frame(
        np.rint(rows).astype(np.uint8), plane_map=PlaneMap.scaled((480, 240), (1200, 1200))
    )
    fewer = measurement_bound(flat, POSES[0], robot, noise=noise).covariance
    assert fewer[0, 0] > 1.2 * straight[0, 0]
    assert fewer[1, 1] > 1.5 * fewer[0, 0]


def test_what_shows_no_markers_or_has_no_area_is_named():
    frame, robot = shown(480, POSES[0])
    good = {"frame": frame, "pose": POSES[0], "robot": robot, "noise": None}
    for name, wrong in (
        ("pose", (1, 2)),
        ("pose", (5000, 600, 0)),
        ("robot", [np.zeros((2, 2))]),
        ("robot", [np.zeros((4, 2))]),
        ("robot", [[(0, 0), (9, 9), (5, 5)]]),
        ("robot", [np.eye(3, 2) * 10_001]),
    ):
        with pytest.raises(ValueError, match=name):
            measurement_bound(**good | {name: wrong})


@pytest.mark.long
def test_markers_that_nobody_sees_have_no_bound():
    grey = Frame(np.full((120, 120, 3), 90, np.uint8))
    with pytest.raises(ValueError, match="frame"):
        measurement_bound(grey, (60, 60, 0), [disc(20)], noise=robsim.GaussianNoise(10))


@pytest.mark.long
def test_an_edge_that_tells_no_place_along_it_has_no_bound():
    image = np.where(np.arange(40) < 20, 70.0, 200.0) * np.ones((40, 1))
    half = [(-50, 0), (50, 0), (50, 50), (-50, 50)]  # forward, right
    with pytest.raises(ValueError, match="robot"):
        measurement_bound(grey_frame(image), (19.5, 20, -np.pi / 2), [half])


def test_a_wrong_pose_is_suspected():
    frame, robot = shown(480, (500, 600, 0.3))
    assert not measurement_bound(frame, (500, 600, 0.3), robot).remarks
    assert "pose" in measurement_bound(frame, (500, 600, 2), robot).remarks[0]
