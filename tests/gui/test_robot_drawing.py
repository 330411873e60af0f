"""A robot while it is drawn."""

import math

import numpy as np
import pytest

import robsim
from robsim.gui.tools.robots.drawing import RobotDrawing
from robsim.vision.robots.sketch import Sketch

PARTS = ("outline", "red", "blue")
SQUARE = np.array([(10.0, 10), (90, 10), (90, 70), (10, 70)])
RED = np.array([(60.0, 20), (80, 20), (80, 40), (60, 40)])
BLUE = RED + np.array((0, 25))


@pytest.fixture
def drawing():
    image = np.full((80, 100, 4), 255, np.uint8)
    return RobotDrawing(Sketch(image, size=120.0))


@pytest.fixture
def drawn(drawing):
    for part, polygon in zip(PARTS, (SQUARE, RED, BLUE), strict=True):
        drawing.put(part, polygon)
    return drawing


def test_it_says_what_is_missing_until_it_is_a_robot(drawing):
    for part, polygon in zip(PARTS, (SQUARE, RED, BLUE), strict=True):
        problems = drawing.sketch.problems()
        assert problems[0].startswith(part)
        with pytest.raises(ValueError, match=part):
            drawing.sketch.definition("mine")
        drawing.put(part, polygon)
        assert len(problems) == len(drawing.sketch.problems()) + 1
    robot = drawing.sketch.definition("mine")
    assert (robot.name, robot.size) == ("mine", 120)
    np.testing.assert_array_equal(robot.outline, SQUARE)
    np.testing.assert_allclose(robot.centre, (50, 40))


def test_problems_are_those_of_a_definition(drawn):
    drawn.move("red", 0, (5, 20))  # out of the outline
    (problem,) = drawn.sketch.problems()
    assert problem.startswith("left marker (red) must lie inside the outline")


def test_corners_on_each_other_are_no_problem_and_a_line_is(drawn):
    drawn.insert("outline", 1, SQUARE[0])
    assert drawn.sketch.problems() == []
    assert len(drawn.sketch.definition("mine").outline) == 4
    drawn.put("red", [(60, 20), (70, 20), (80, 20)])
    assert drawn.sketch.problems() == [
        "left marker (red) must be a polygon of nonzero area, got points on a line"
    ]


def test_each_change_is_undone_and_done_again(drawn):
    before = drawn.sketch
    drawn.insert("outline", 4, (3, 40))
    drawn.insert("outline", 0, (20, 5))
    drawn.remove("outline", 1)
    after = drawn.sketch
    np.testing.assert_array_equal(after.outline, [(20, 5), *SQUARE[1:], (3, 40)])
    for _ in range(3):
        drawn.undo()
    assert drawn.sketch is before
    for _ in range(3):
        drawn.redo()
    assert drawn.sketch is after
    assert not drawn.can_redo
    drawn.undo()
    drawn.turn(1)
    assert not drawn.can_redo  # what was undone is gone
    for _ in range(20):
        drawn.undo()
    assert not drawn.can_undo
    assert drawn.sketch.outline.shape == (0, 2)


def test_only_so_many_changes_are_kept(drawing):
    for _ in range(700):
        drawing.turn(1)
        assert abs(drawing.sketch.alignment) <= 180
    while drawing.can_undo:
        drawing.undo()
    assert drawing.sketch.alignment == pytest.approx(np.remainder(200 + 180, 360) - 180)


def test_a_drag_is_one_change(drawn):
    before = drawn.sketch
    drawn.move("red", 0, (61, 21))
    for k in range(5):
        drawn.move("red", 0, (62 + k, 22), goes_on=True)
    assert drawn.sketch.markers["red"][0].tolist() == [66, 22]
    drawn.undo()
    assert drawn.sketch is before
    for towards in ((90, 40), (50, 75), (20, 10), (11, 40)):
        drawn.face(towards, goes_on=towards != (90, 40))
        ((forward, right),) = drawn.sketch.definition("mine").to_robot_frame([towards])
        assert forward > 0
        assert right == pytest.approx(0, abs=1e-9)
    drawn.undo()
    assert drawn.sketch is before


def test_what_is_wrong_is_refused_and_changes_nothing(drawn):
    before = drawn.sketch
    for call, said in (
        (lambda: drawn.put("green", RED), "part must"),
        (lambda: drawn.put("red", [(1, math.nan), (2, 3), (4, 5)]), "polygon"),
        (lambda: drawn.put("red", np.zeros((201, 2))), "at most 200 corners"),
        (lambda: drawn.move("red", 4, (1, 2)), "corner"),
        (lambda: drawn.insert("red", 5, (1, 2)), "corner"),
        (lambda: drawn.remove("red", -1), "corner"),
        (lambda: drawn.turn(math.inf), "degrees"),
        (lambda: drawn.face(drawn.sketch.middle), "towards"),
        (lambda: drawn.scale((1, 1), (1, 1), 5), "a pixel apart"),
        (lambda: drawn.scale((1, 1), (2, 1), 9000), "size"),
    ):
        with pytest.raises((TypeError, ValueError), match=said):
            call()
        assert drawn.sketch is before


def test_a_centre_that_was_given_stays_until_there_is_another_outline(user_folder):
    lab = robsim.load_robot("lab")
    with robsim.gui.robot_panel(robot="lab") as tool:
        drawing = tool._view.drawing
    drawing.insert("red", 0, lab.markers["right"].polygon[0] + 1)
    np.testing.assert_array_equal(drawing.sketch.definition("mine").centre, lab.centre)
    drawing.move("outline", 0, lab.outline[0] + 1)
    assert np.abs(drawing.sketch.middle - lab.centre).max() > 1
    drawing.undo()
    np.testing.assert_array_equal(drawing.sketch.middle, lab.centre)


@pytest.mark.long
@pytest.mark.parametrize("name", ["lab", "robot2", "sheep"])
def test_a_robot_that_ships_can_be_taken_up_and_given_back(user_folder, name):
    with robsim.gui.robot_panel(robot=name) as tool:
        assert tool._view.drawing.sketch.problems() == []
        assert tool.value == robsim.load_robot(name)
