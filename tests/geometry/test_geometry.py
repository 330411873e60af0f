"""Polygons and poses, on small cases by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as npst

import robsim
from drawn_robots import box, star
from robsim.vision.robots import polygons
from scenes import small_renderer

# --- polygons


SQUARE = box(0, 0, 4, 4)
# A square with a notch from the right, as deep as to (1, 2).
NOTCHED = np.array([(0, 0), (4, 0), (4, 1.5), (1, 2), (4, 2.5), (4, 4), (0, 4)], float)


@pytest.mark.kernels
def test_area_and_centroid():
    area, centroid = polygons.area_and_centroid(box(1, 2, 5, 4))
    assert area == 8
    np.testing.assert_array_equal(centroid, [3, 3])
    area, centroid = polygons.area_and_centroid(np.array([(0, 0), (0, 3), (3, 0)], float))
    assert area == 4.5
    np.testing.assert_allclose(centroid, [1, 1])


@pytest.mark.kernels
def test_fitted_has_the_area_and_the_centroid():
    area, centroid = polygons.area_and_centroid(polygons.fitted(NOTCHED, 50.0, np.array((7, -8))))
    assert area == pytest.approx(50)
    np.testing.assert_allclose(centroid, [7, -8])


@pytest.mark.kernels
def test_contains_and_depths():
    points = np.array([(2, 2), (0.5, 2), (5, 2), (7, 8), (3, 2)])
    np.testing.assert_array_equal(
        polygons.contains(SQUARE, points), [True, True, False, False, True]
    )
    np.testing.assert_allclose(polygons.depths(SQUARE, points), [2, 0.5, -1, -5, 1])
    inside_notch = polygons.depths(NOTCHED, np.array([(3.0, 2.0)]))
    np.testing.assert_allclose(inside_notch, -2 * 0.5 / np.hypot(3, 0.5))


@pytest.mark.kernels
def test_samples_lie_on_the_sides_with_all_corners():
    points = polygons.samples(NOTCHED)
    np.testing.assert_allclose(polygons.distances(NOTCHED, points), 0, atol=1e-12)
    assert {tuple(p) for p in NOTCHED} <= {tuple(p) for p in points}
    gaps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    assert gaps.max() <= 1
    assert len(polygons.samples(1e5 * SQUARE)) < 2010


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("polygon", "sides"),
    [
        (SQUARE, None),
        (NOTCHED, None),
        (SQUARE[::-1], None),
        (SQUARE[:3], None),
        ([(0, 0), (4, 4), (4, 0), (0, 4)], (0, 2)),  # a bow tie
        ([(0, 0), (4, 0), (4, 4), (5, 4), (5, 2), (0, 2)], (1, 4)),
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], (0, 2)),  # a corner on a side
        ([(0, 0), (9, 0), (5, 0), (5, 5)], (0, 2)),  # there and back
        ([(0, 0), (4, 0), (2, 2), (0, 4), (4, 4), (2, 2)], (1, 4)),  # a corner twice
    ],
)
def test_crossing(polygon, sides):
    assert polygons.crossing(np.array(polygon, float)) == sides


@pytest.mark.kernels
def test_random_stars_do_not_cross_but_with_two_corners_swapped_they_do(rng):
    for _ in range(40):
        polygon = star(rng, rng.uniform(-50, 50, 2), 30)
        assert polygons.crossing(polygon) is None
        polygon[[1, 3]] = polygon[[3, 1]]
        assert polygons.crossing(polygon) is not None


@pytest.mark.kernels
def test_mask():
    mask = polygons.mask(box(0.5, 1.5, 3.5, 5.5), 6, 8)
    assert mask.shape == (8, 6)
    down, right = np.nonzero(mask)
    assert (right.min(), right.max(), down.min(), down.max()) == (1, 3, 2, 5)
    assert mask.sum() == 12


@pytest.mark.kernels
def test_mask_is_what_contains_says_of_the_pixels(rng):
    down, right = np.mgrid[:30, :40]
    points = np.column_stack((right.ravel(), down.ravel())).astype(float)
    for _ in range(10):
        polygon = star(rng, rng.uniform(0, 30, 2), 20)  # some of it beyond the picture
        covered = polygons.mask(polygon, 40, 30)
        np.testing.assert_array_equal(covered.ravel(), polygons.contains(polygon, points))


# --- poses


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
