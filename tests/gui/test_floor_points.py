"""Points on the floor while they are placed, without a picture."""

import pytest

from robsim.gui.tools.floor.points import MOST, FloorDraft, FloorPoints

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
    assert points.draft.problems()[0].startswith("point 1 has no place")
    points.add((1.1, 2), (3, 4))
    assert any("points 1 and 2 lie on each other" in one for one in points.draft.problems())
    before = points.draft
    for act, said in (
        (lambda: points.add((1, float("nan"))), "pixel must"),
        (lambda: points.add((1, 1e9)), "pixel must"),
        (lambda: points.add((1, 2), 3), "position must"),
        (lambda: points.move(7, (1, 2)), "point 7"),
        (lambda: points.nudge(1, 3), "by must"),
        (lambda: points.put([(1, 2)], [(1, 2), (3, 4)]), "as many"),
        (lambda: points.put([(1, 2)] * (MOST + 1), [(1, 2)] * (MOST + 1)), f"at most {MOST}"),
        (lambda: points.adjust(area=(3, 3)), "area must"),
        (lambda: points.adjust(marker_height=-1), "marker_height must"),
    ):
        with pytest.raises((TypeError, ValueError), match=said):
            act()
        assert points.draft is before
