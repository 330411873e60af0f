"""Points on the floor while they are placed, without a picture."""

import pytest

from robsim.gui._tools.floor.points import MOST, FloorDraft, FloorPoints

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


def test_what_is_missing_or_wrong_is_said(points):
    assert points.draft.problems() == [
        "place 4 points more: 4 are needed, with 6 a wrong one shows"
    ]
    for pixel, place in SQUARE:
        points.add(pixel, place)
    assert points.draft.problems() == []
    points.place(2, (0, 0))
    assert "points 1 and 2 have the same place on the floor" in points.draft.problems()
    points.place(2, None)
    assert "point 2 has no place on the floor yet: give x and y" in points.draft.problems()
    points.place(3, (1, None))
    assert "points 2, 3 have no place" in points.draft.problems()[0]
    points.move(4, (10.2, 10.1))
    assert "points 1 and 4 lie on each other in the picture" in points.draft.problems()


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda p: p.add((1, float("nan"))), "pixel must be finite"),
        (lambda p: p.add((1, 1e9)), "pixel must lie in the picture"),
        (lambda p: p.add((1, 2), 3), "position must be"),
        (lambda p: p.add((1, 2), (3, "a")), "position: y must be"),
        (lambda p: p.move(7, (1, 2)), "there is no point 7"),
        (lambda p: p.move(True, (1, 2)), "point must be"),
        (lambda p: p.nudge(1, 3), "by must be"),
        (lambda p: p.put([(1, 2)], [(1, 2), (3, 4)]), "as many"),
        (lambda p: p.put([(1, 2)] * (MOST + 1), [(1, 2)] * (MOST + 1)), f"at most {MOST}"),
        (lambda p: p.adjust(area=(3, 3)), "area must"),
        (lambda p: p.adjust(mm_per_px=0), "mm_per_px must"),
        (lambda p: p.adjust(marker_height=-1), "marker_height must"),
    ],
)
def test_what_is_refused_changes_nothing(points, act, said):
    points.add((1, 2))
    before = points.draft
    with pytest.raises((TypeError, ValueError), match=said):
        act(points)
    assert points.draft is before
