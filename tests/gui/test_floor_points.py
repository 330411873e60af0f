"""Points on the floor, and the corners near them."""

import numpy as np
import pytest

from browsers import pixels_of_floor, tiled_floor
from robsim.gui.tools.floor.corners import snapped
from robsim.gui.tools.floor.points import MOST, FloorDraft, FloorPoints

# --- points


SQUARE = [((10, 10), (0, 0)), ((90, 12), (100, 0)), ((88, 91), (100, 100)), ((9, 90), (0, 100))]


@pytest.fixture
def points():
    return FloorPoints(FloorDraft(area=(200, 100), mm_per_px=2.0))


def test_points_are_numbered_moved_and_removed(points):
    assert [points.add(pixel, place) for pixel, place in SQUARE] == [1, 2, 3, 4]
    points.remove(2)
    assert points.add((50, 50)) == 5  # those that are there keep their numbers
    points.move(3, (80.25, 90.5))
    points.nudge(3, (0.1, -0.2))
    assert points.point(3).pixel == pytest.approx((80.35, 90.3))
    points.place(5, (50, None))
    assert not points.point(5).is_complete
    assert [one.number for one in points.draft.complete] == [1, 3, 4]
    assert points.draft.places.tolist() == [[0, 0], [100, 100], [0, 100]]
    points.clear()
    assert points.draft.points == ()


def test_each_change_is_undone_and_a_drag_is_one(points):
    points.add((10, 20))
    points.move(1, (11, 20))
    for u in range(12, 20):
        points.move(1, (u, 20), goes_on=True)
    points.adjust(area=(300, 300), mm_per_px=3, marker_height=50)
    points.undo()
    assert points.draft.area == (200, 100)
    points.undo()
    assert points.point(1).pixel == (10, 20)
    points.redo()
    assert points.point(1).pixel == (19, 20)
    points.move(1, (5, 5))
    assert not points.can_redo
    for _ in range(9):
        points.undo()
    assert points.draft.points == ()
    assert not points.can_undo


def test_what_is_refused_changes_nothing(points):
    points.add((1, 2))
    assert points.draft.problems()[0].startswith("point 1 has no position")
    points.add((1.1, 2), (3, 4))
    assert any("points 1 and 2 coincide" in one for one in points.draft.problems())
    before = points.draft
    for act, said in (
        (lambda: points.add((1, float("nan"))), "pixel must"),
        (lambda: points.add((1, 1e9)), "pixel must"),
        (lambda: points.add((1, 2), 3), "position must"),
        (lambda: points.move(7, (1, 2)), "point 7"),
        (lambda: points.nudge(1, 3), "by must"),
        (lambda: points.put([(1, 2)], [(1, 2), (3, 4)]), "same length"),
        (lambda: points.put([(1, 2)] * (MOST + 1), [(1, 2)] * (MOST + 1)), f"at most {MOST}"),
        (lambda: points.adjust(area=(3, 3)), "area must"),
        (lambda: points.adjust(marker_height=-1), "marker_height must"),
    ):
        with pytest.raises((TypeError, ValueError), match=said):
            act()
        assert points.draft is before


# --- corners


SIZE, FINE = 100, 6
AT = np.array((50.3, 48.7))


def picture(dark):
    """A picture of what is dark by its place, from a turn about a point, through a blur."""
    across = (np.arange(SIZE * FINE) + 0.5) / FINE - 0.5
    u, v = np.meshgrid(across - AT[0], across - AT[1])
    x, y = np.cos(0.3) * u + np.sin(0.3) * v, np.cos(0.3) * v - np.sin(0.3) * u
    levels = np.where(dark(x, y), 50.0, 190.0).reshape(SIZE, FINE, SIZE, FINE).mean(axis=(1, 3))
    levels = np.pad(levels, 1, mode="edge")
    levels = (levels[:-2] + 2 * levels[1:-1] + levels[2:]) / 4
    levels = (levels[:, :-2] + 2 * levels[:, 1:-1] + levels[:, 2:]) / 4
    levels += 2 * np.random.default_rng(3).standard_normal(levels.shape)
    return np.repeat(np.clip(np.rint(levels), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


PATTERNS = {
    "joint": lambda x, y: (abs(x) < 1.5) | (abs(y) < 1.5),
    "chessboard": lambda x, y: x * y > 0,
    "corner": lambda x, y: (x > 0) & (y > 0),
    "dot": lambda x, y: np.hypot(x, y) < 4,
}


def test_it_is_found_to_a_tenth_of_a_pixel():
    for dark in PATTERNS.values():
        image = picture(dark)
        for off in ((0, 0), (5, -4), (-6, 3)):
            assert snapped(image, tuple(AT + off), 12) == pytest.approx(tuple(AT), abs=0.1)


def test_nothing_is_found_on_a_plain_floor_on_an_edge_or_out_of_reach():
    for dark in (lambda x, _: x > 1e9, lambda x, _: x > 0):
        assert snapped(picture(dark), (50, 50), 12) is None
    assert snapped(picture(PATTERNS["corner"]), (70, 70), 9) is None


def test_the_edges_of_the_picture_do_no_harm():
    for at in ((-500, 20), (0, 0), (99, 99), (1e6, 1e6)):
        snapped(picture(PATTERNS["joint"]), at, 12)


def test_joints_of_the_tiles_of_the_example():
    places = np.array([(x, y) for x in (300, 900, 2100) for y in (300, 1500, 2100)], float)
    true = pixels_of_floor(places)
    found = [
        snapped(tiled_floor(), tuple(np.rint(pixel) + np.array((2, -2))), 10) for pixel in true
    ]
    off = np.linalg.norm(np.array(found) - true, axis=1)
    assert off.max() < 0.4
    assert np.sqrt((off**2).mean()) < 0.25
