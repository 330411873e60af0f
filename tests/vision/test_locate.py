import numpy as np
import pytest

import robsim
from scenes import errors_of, false_poses, poses_within, renderer, rms
from sizes import thorough


@pytest.mark.long
def test_continuous_rotation_in_light_shadow_and_at_its_edge(rng):
    errors = errors_of(renderer(), poses_within(rng, thorough(1000, 300)))
    # Where the robot covers the red square in part, not to see it would be right, too.
    assert np.isfinite(errors).all()
    place, heading = rms(errors)
    assert place < 0.10
    assert heading < 0.15


def test_parked_exactly_along_an_axis():
    shifts = np.arange(0, 1, 0.25)
    poses = [
        (600 + dx, 700 + dy, heading)
        for dx in shifts
        for dy in shifts
        for heading in (0.0, np.pi / 2, np.pi, -np.pi / 2)
    ]
    errors = errors_of(renderer(), np.array(poses))
    assert np.hypot(errors[:, 0], errors[:, 1]).max() < 0.4


def test_a_wrong_offset_oscillates_around_the_true_centre():
    headings = np.deg2rad(np.arange(0, 360, 10))
    poses = np.column_stack((np.full((36, 2), 400.0), headings))
    errors = errors_of(renderer(), poses, markers=robsim.vision.MarkerLayout(43, 15))
    expected = np.column_stack((np.cos(headings), np.sin(headings)))
    np.testing.assert_allclose(errors[:, :2], expected, atol=0.15)


def test_no_false_pose_of_a_robot_half_out_of_the_view(rng):
    along = rng.uniform(0, 1200, 200)
    across = rng.uniform(-40, 40, 200)
    side = rng.integers(4, size=200)
    x = np.choose(side, [along, along, across, 1199 - across])
    y = np.choose(side, [across, 1199 - across, along, along])
    errors = errors_of(renderer(), np.column_stack((x, y, rng.uniform(-np.pi, np.pi, 200))))
    assert not false_poses(errors).any()
    assert 0.02 < np.isfinite(errors[:, 0]).mean() < 0.9


@pytest.mark.long
def test_no_false_pose_among_discs_as_red_and_as_large_as_the_marker(rng):
    places = rng.uniform(50, 1150, (40, 2))
    v, u = np.mgrid[:30, :30]

    def scatter(background):
        for x, y in places:
            left, top = int(x) - 15, int(y) - 15
            is_disc = (left + u - x) ** 2 + (top + v - y) ** 2 < 13**2
            background[top : top + 30, left : left + 30][is_disc] = (199, 37, 41)
        return background

    errors = errors_of(renderer(adjust_background=scatter), poses_within(rng, thorough(300, 120)))
    assert not false_poses(errors).any()
    assert np.isfinite(errors[:, 0]).mean() > 0.7
