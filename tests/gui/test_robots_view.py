"""The panel that defines a robot, without a browser."""

import math

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser, settled
from drawn_robots import covered
from python_devices import PATIENT, EndlessCamera
from robsim.gui.tools.robots.drawing import RobotDrawing
from robsim.vision import load_colors, load_robot
from robsim.vision.robots.sketch import Sketch, guess_marker, guess_outline
from waiting import wait_for

# --- the panel


@pytest.fixture
def view(user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        yield tool._view


@pytest.fixture
def browser(view):
    browser = FakeBrowser(view, 200)
    browser.take("frame")
    return browser


@pytest.mark.long
def test_a_robot_is_shown_as_it_is(view, browser):
    state = view._state()
    robot = load_robot("lab")
    assert state["mode"] == "draw"
    assert not state["can_capture"]
    assert state["problems"] == []
    assert {"lab", "robot2", "sheep"} <= set(state["robots"])
    np.testing.assert_array_equal(state["parts"]["outline"], robot.outline)
    assert state["alignment"] == robot.alignment


@pytest.mark.long
def test_corners_heading_and_size_are_changed_and_undone(view, browser):
    browser.say("part", name="red")
    before = view.drawing.sketch
    robot = load_robot("lab")
    browser.say("move", corner=0, at=[20, 30], goes_on=False)
    browser.say("move", corner=0, at=[21, 31], goes_on=True)
    browser.say("insert", corner=1, at=[22, 32])
    browser.say("cut", corner=2)
    browser.say("turn", degrees=-10)
    browser.say("scale", one=[0, 0], other=[30, 40], distance=25)
    settled(view)
    assert view._state()["parts"]["red"][:2] == [[21, 31], [22, 32]]
    assert view.drawing.sketch.alignment == pytest.approx(robot.alignment - 10)
    assert view.drawing.sketch.size == pytest.approx(robot.image.shape[1] / 2)
    for _ in range(5):
        browser.say("undo")
    settled(view)
    assert view.drawing.sketch is before
    assert view._state()["can_redo"]
    browser.say("clear")
    settled(view)
    assert view._state()["problems"] == ["red marker needs at least 3 corners"]


@pytest.mark.long
def test_another_robot_is_loaded_and_saved_under_a_new_name(view, browser):
    browser.say("load", name="robot2")
    browser.say("turn", degrees=90)
    browser.say("save", name="mine", overwrite=False)
    browser.take("note", level="info")
    mine = load_robot("mine")
    turned = mine.alignment - load_robot("robot2").alignment
    assert turned % 360 == pytest.approx(90)
    browser.say("save", name="lab", overwrite=False)
    assert "lab" in browser.take("note", level="error")[0]["text"]
    browser.say("save", name="mine", overwrite=False)
    assert "mine" in browser.take("note", level="error")[0]["text"]
    browser.say("save", name="mine", overwrite=True)
    browser.take("note", level="info")


@pytest.mark.long
def test_what_is_wrong_is_said_and_changes_nothing(view, browser):
    before = view.drawing.sketch
    for kind, fields, said in (
        ("load", {"name": "nobody"}, "nobody"),
        ("part", {"name": "green"}, "part must be one of outline, red, blue"),
        ("move", {"corner": 99, "at": [1, 2], "goes_on": False}, "corner"),
        ("capture", {}, "no live picture"),
        ("resume", {}, "no camera"),
        ("save", {"name": "a/b", "overwrite": False}, "name"),
        ("scale", {"one": [1, 1], "other": [1, 1], "distance": 3}, "one pixel apart"),
    ):
        browser.say(kind, **fields)
        assert said in browser.take("note", level="error")[0]["text"]
    assert view.drawing.sketch is before


@pytest.mark.long
def test_a_robot_is_captured_from_a_camera(user_folder):
    sim = robsim.Simulation(robot="lab", start=(400, 500, 0.6), headings=None, seed=2)
    frame = sim.step().frame
    with (
        robsim.Camera(EndlessCamera(np.array(frame.image)), **PATIENT) as camera,
        robsim.gui.robot_panel(camera, robot="sheep") as tool,
    ):
        view = tool._view
        browser = FakeBrowser(view, 200)
        browser.take("frame")
        assert view._state()["mode"] == "capture"
        side = 3 * load_robot("lab").radius
        browser.say("square", at=[400, 500], side=side)
        browser.say("capture")
        wait_for(lambda: view._state()["mode"] == "draw")
        state = view._state()
        assert state["problems"] == []
        robot = view.drawing.sketch.definition("seen")
        true = load_robot("lab")
        assert robot.radius * side / robot.size == pytest.approx(true.radius, rel=0.1)
        assert robot.image[0, 0, 3] == 0  # the floor is cut off
        assert not state["can_undo"]
        browser.say("resume")
        wait_for(lambda: view._state()["mode"] == "capture")


@pytest.mark.long
def test_reset_goes_back_to_how_it_began_and_can_be_undone(user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        begun = tool.value
        tool.turn(20)
        turned = tool.value.alignment
        tool.message("reset")
        assert tool.value is begun
        tool.undo()
        assert tool.value.alignment == turned
        tool.load(np.array(load_robot("sheep").image))
        outline = tool._view.drawing.sketch.outline
        tool.message("clear")
        tool.message("reset")
        np.testing.assert_array_equal(tool._view.drawing.sketch.outline, outline)


# --- first guesses


def picture(name, noise=None):
    """A robot on the floor, cut out of a frame, its pose, and what takes its points there."""
    robot = robsim.load_robot(name)
    pose = np.array((300, 300, 0.6))
    options = {"area": (600, 600), "headings": None, "seed": 2, "noise": noise}
    frame = robsim.Simulation(robot=robot, start=tuple(pose), **options).step().frame
    half = int(robot.radius * 1.5)
    cut = frame.image[300 - half : 300 + half, 300 - half : 300 + half]
    return robot, np.ascontiguousarray(cut), pose - (300 - half, 300 - half, 0)


def placed(robot, polygon, pose):
    forward, right = robot.to_robot_frame(polygon).T
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.column_stack([pose[0] + c * forward - s * right, pose[1] + s * forward + c * right])


def overlap(one, other, image):
    one, other = covered(one, image), covered(other, image)
    return (one & other).sum() / (one | other).sum()


@pytest.mark.parametrize(("name", "noise"), [("robot2", None), ("lab", robsim.GaussianNoise(10))])
def test_the_outline_is_about_that_of_the_robot(name, noise):
    robot, image, pose = picture(name, noise)
    found = guess_outline(image)
    assert overlap(found, placed(robot, robot.outline, pose), image) > 0.75


def test_the_markers_are_those_of_the_robot():
    robot, image, pose = picture("lab")
    outline = guess_outline(image)
    for marker in robot.markers.values():
        found = guess_marker(image, outline, marker.color, load_colors())
        assert overlap(found, placed(robot, marker.polygon, pose), image) > 0.6


def test_a_bare_floor_has_no_robot():
    floor = np.full((90, 120, 3), 128, np.uint8)
    with pytest.raises(ValueError, match="no object differs from the floor"):
        guess_outline(floor)
    rng = np.random.default_rng(1)
    noisy = np.clip(128 + 12 * rng.standard_normal((90, 120, 3)), 0, 255).astype(np.uint8)
    with pytest.raises(ValueError, match="no object differs from the floor"):
        guess_outline(noisy)


def test_a_marker_outside_of_the_outline_is_none():
    image = np.full((90, 120, 3), 128, np.uint8)
    image[5:15, 5:15] = (210, 40, 30)
    outline = np.array([(30.0, 20), (90, 20), (90, 70), (30, 70)])
    with pytest.raises(ValueError, match="red marker: nothing in the image"):
        guess_marker(image, outline, "red", load_colors())


# --- drawing


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
        (lambda: drawn.scale((1, 1), (1, 1), 5), "one pixel apart"),
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
