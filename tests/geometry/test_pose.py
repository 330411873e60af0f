import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as npst

import robsim
from scenes import small_renderer


def test_wrapped_angles_lie_in_the_half_open_range_and_differ_by_full_turns(rng):
    angles = rng.uniform(-100, 100, 10_000)
    wrapped = robsim.wrap_angle(angles)
    assert (wrapped > -np.pi).all()
    assert (wrapped <= np.pi).all()
    turns = (angles - wrapped) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-12)


def test_wrap_angle_of_single_values():
    for angle, wrapped in (
        (0.0, 0.0),
        (np.pi, np.pi),
        (-np.pi, np.pi),
        (3 * np.pi, np.pi),
        (np.pi + 0.25, -np.pi + 0.25),
        (-1.5, -1.5),
    ):
        assert robsim.wrap_angle(angle) == pytest.approx(wrapped, abs=1e-12)


@given(pose=npst.arrays(float, 3, elements={"allow_subnormal": True}))
def test_a_pose_of_floats_is_kept_or_refused(pose):
    if np.isfinite(pose).all():
        x, y, heading = robsim.Measurement(pose).pose
        assert (x, y) == (pose[0], pose[1])
        assert -np.pi < heading <= np.pi
    else:
        with pytest.raises(ValueError, match="pose"):
            robsim.Measurement(pose)


def test_poses_of_any_layout_are_taken():
    for pose in (
        np.array((1, 2, 3), dtype=">f8"),
        np.array((1, 2, 3), dtype=np.float32),
        np.array([3.0, 2.0, 1.0])[::-1],
        np.array([1, 2, 3]),
        range(1, 4),
    ):
        np.testing.assert_array_equal(robsim.Measurement(pose).pose, (1, 2, 3))


def test_poses_and_covariances_of_other_shapes_are_refused():
    pose = (1, 2, 3)
    for take, name in (
        (robsim.Measurement, "pose"),
        (lambda wrong: robsim.Estimate(wrong, np.eye(3)), "pose"),
        (small_renderer().render, "pose"),
        (lambda wrong: robsim.Simulation(start=wrong), "start"),
    ):
        for wrong in ((), (1, 2), (1, 2, 3, 4), [pose], [[1], [2, 3], 4], np.zeros((3, 3))):
            with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                take(wrong)
    for wrong in (np.eye(2), np.zeros(9), np.eye(3) * np.nan):
        with pytest.raises(ValueError, match="covariance"):
            robsim.Estimate(pose, wrong)
    for wrong in (np.eye(2), [np.nan]):
        with pytest.raises(ValueError, match="state"):
            robsim.Estimate(pose, np.eye(3), wrong)
