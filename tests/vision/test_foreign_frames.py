"""Frames drawn by other code: that they are right, and how the measurement is judged by them."""

import numpy as np
import pytest

import robsim
from foreign_accuracy import Errors, compared, counted, worse
from foreign_frames import (
    BODY,
    CASES,
    NARROW,
    RED,
    VIEWS,
    Case,
    View,
    before,
    coverage,
    frames,
    marker_polygons,
    paint_robot,
    placed,
)

SMALL = VIEWS["10.5 px"]


def area(corners):
    x, y = corners.T if len(corners) else np.zeros((2, 1))
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def clipped(corners, column, row):
    """The area of a polygon in one pixel, from its corners cut off at the four sides."""
    for normal, limit in (
        ((-1, 0), -column),
        ((1, 0), column + 1),
        ((0, -1), -row),
        ((0, 1), row + 1),
    ):
        if len(corners):
            corners = before(corners, np.array(normal, float), limit)
    return area(corners)


def polygon(rng, corners):
    """Corners around the middle of 10 x 10 px, star-shaped."""
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.9, corners)) / corners
    reach = rng.uniform(2, 4.9, corners)
    return 5 + reach[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))


@pytest.mark.parametrize("corners", [3, 24])
def test_a_pixel_takes_the_share_of_a_polygon_that_it_covers(rng, corners):
    drawn = polygon(rng, corners)
    exact = [[clipped(drawn, column, row) for column in range(10)] for row in range(10)]
    np.testing.assert_allclose(coverage(drawn, 10, 10), exact, atol=1e-12)
    np.testing.assert_allclose(coverage(drawn[::-1], 10, 10), exact, atol=1e-12)


def sampled(polygon, first, size, fold=32):
    """The share of fold x fold points of each pixel that lie in a convex polygon."""
    place = (np.arange(size * fold) + 0.5) / fold
    x, y = first[0] + place[None, :], first[1] + place[:, None]
    middle = polygon.mean(axis=0)
    inside = np.ones((size * fold, size * fold), bool)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        side = (x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)
        inside &= side * ((middle[0] - x0) * (y1 - y0) - (middle[1] - y0) * (x1 - x0)) >= 0
    return inside.reshape(size, fold, size, fold).mean(axis=(1, 3))


def painted(colors, view, pose, tilted):
    """The levels of a robot with markers of these colours on a plain floor."""
    levels = np.full((*view.resolution[::-1], 3), 150.0)
    paint_robot(levels, Case(tilted=tilted, colors=colors), view, pose)
    return levels


@pytest.mark.long
@pytest.mark.parametrize("tilted", [False, True])
def test_a_marker_stands_within_a_thousandth_of_a_pixel_of_where_it_should(tilted):
    view = View((160, 160), 0.9)
    # one pose: the points themselves are off by .0002 px (rms), and by .001 px at the worst of many
    pose = view.pose_in_view(np.random.default_rng(5), tilted=tilted)
    for marker, corners in enumerate(marker_polygons("lab")):
        colors = [BODY, BODY]
        without = painted(colors, view, pose, tilted)
        colors[marker] = RED
        way = np.subtract(RED, BODY)
        share = (painted(colors, view, pose, tilted) - without) @ way / (way @ way)
        seen = view.pixels(placed(corners, pose), tilted)
        first = np.floor(seen.min(axis=0)).astype(int) - 1
        size = int(np.ceil(seen.max(axis=0) - first).max()) + 2
        share = share[first[1] : first[1] + size, first[0] : first[0] + size]
        expected = sampled(seen + 0.5, first, size)
        assert np.abs(share - expected).max() < 0.02  # what 32 x 32 points leave open
        for axis in (0, 1):
            places = [one.sum(axis=axis) @ np.arange(size) / one.sum() for one in (share, expected)]
            assert abs(places[0] - places[1]) < 0.001


def test_the_plane_map_is_that_of_the_drawing(rng):
    positions = rng.uniform(0, 400, (20, 2))
    for view in VIEWS.values():
        for tilted in (False, True):
            plane_map = view.plane_map(tilted)
            np.testing.assert_allclose(
                plane_map.to_pixel(positions), view.pixels(positions, tilted), atol=1e-9
            )
            middle = (np.array(view.resolution) - 1) / 2
            assert plane_map.to_world(middle) == pytest.approx(np.array(view.area) / 2 - 0.5)
    straight = robsim.imaging.PlaneMap.scaled(SMALL.resolution, SMALL.area)
    np.testing.assert_allclose(straight.matrix, SMALL.plane_map().matrix, atol=1e-12)


# --- what the camera adds


def test_a_case_gives_the_same_frames_whatever_else_is_drawn():
    first = [
        (frame.image.copy(), pose) for frame, pose in frames("tilted, Gaussian 10 %", SMALL, 2)
    ]
    list(frames("uniform 10 %", SMALL, 1))
    for (image, pose), (again, same) in zip(
        first, frames("tilted, Gaussian 10 %", SMALL, 2), strict=True
    ):
        np.testing.assert_array_equal(image, again.image)
        np.testing.assert_array_equal(pose, same)
    assert not np.array_equal(first[0][1], first[1][1])


# --- how errors are judged


def errors_of(spread, count=80, *, missed=(), false=()):
    rng = np.random.default_rng(3)
    poses = rng.normal(0, spread, (count, 3)) * (1, 1, 0.02)
    poses[list(missed)] = np.nan
    poses[list(false)] = 50
    return Errors(poses, np.full(count, 3.0))


def test_worse_is_what_exceeds_the_spread():
    old = errors_of(0.1)
    for new, reasons in (
        (old, []),
        (errors_of(0.102), []),
        (errors_of(0.12), ["place", "heading"]),
        (errors_of(0.1, missed=range(3)), []),
        (errors_of(0.1, missed=range(12)), ["misses"]),
        (errors_of(0.1, false=range(12)), ["false poses"]),
    ):
        assert worse(new, old) == reasons
    errors = errors_of(0.1, missed=range(4), false=(5, 6))
    assert (np.sum(~errors.found), errors.false.sum(), errors.good.sum()) == (4, 2, 74)
    assert errors.nees == 1
    assert errors.rms()[0] == pytest.approx(0.1 * np.sqrt(2), rel=0.2)


#: Of the blobs' centroids: rms in px of the work area, at most, for both sizes of markers.
COUNTED = {
    "clean": (0.09, 0.22),
    "JPEG 75": (0.13, 0.42),
    "Gaussian 20 %": (0.28, 0.70),
    "tilted": (0.22, 0.35),
    "other markers": (0.12, 0.30),
}


@pytest.mark.long
@pytest.mark.parametrize("name", COUNTED)
def test_the_blobs_are_where_the_robot_is(name):
    if CASES[name].jpeg:
        pytest.importorskip("cv2")
    # in a narrow view a tilted camera would stand close to the floor
    views = VIEWS if CASES[name].tilted else NARROW
    for view, limit in zip(views.values(), COUNTED[name], strict=True):
        found = compared(name, view, 6, {"counted": counted})["counted"]
        assert found.good.all()
        assert found.rms()[0] < limit
