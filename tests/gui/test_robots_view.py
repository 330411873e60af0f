"""The panel that defines a robot, without a browser."""

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser, settled
from python_cameras import PATIENT, EndlessCamera
from robsim.vision import load_robot
from waiting import wait_for

pytestmark = pytest.mark.long


@pytest.fixture
def view(user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        yield tool._view


@pytest.fixture
def browser(view):
    browser = FakeBrowser(view, 200)
    browser.take("frame")
    return browser


def test_a_robot_is_shown_as_it_is(view, browser):
    state = view._state()
    robot = load_robot("lab")
    assert state["mode"] == "draw"
    assert not state["can_capture"]
    assert state["problems"] == []
    assert {"lab", "robot2", "sheep"} <= set(state["robots"])
    np.testing.assert_array_equal(state["parts"]["outline"], robot.outline)
    assert state["alignment"] == robot.alignment


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
    assert view._state()["problems"] == ["red marker needs 3 corners at least"]


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


def test_what_is_wrong_is_said_and_changes_nothing(view, browser):
    before = view.drawing.sketch
    for kind, fields, said in (
        ("load", {"name": "nobody"}, "nobody"),
        ("part", {"name": "green"}, "part must be one of outline, red, blue"),
        ("move", {"corner": 99, "at": [1, 2], "goes_on": False}, "corner"),
        ("capture", {}, "no live picture"),
        ("resume", {}, "no camera"),
        ("save", {"name": "a/b", "overwrite": False}, "name"),
        ("scale", {"one": [1, 1], "other": [1, 1], "distance": 3}, "a pixel apart"),
    ):
        browser.say(kind, **fields)
        assert said in browser.take("note", level="error")[0]["text"]
    assert view.drawing.sketch is before


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
