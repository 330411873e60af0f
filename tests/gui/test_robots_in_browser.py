"""The panel that defines a robot, with the mouse and the keys, in Chromium."""

import numpy as np
import pytest

import robsim
from panel_mouse import ToolMouse
from robsim.vision import load_robot
from waiting import wait_for

pytestmark = pytest.mark.slow


@pytest.fixture
def mouse(open_tool, user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        mouse = ToolMouse(tool, open_tool(tool))
        mouse.drawing = tool._view.drawing
        yield mouse


def test_corners_are_dragged_put_on_edges_and_removed(mouse):
    before = mouse.drawing.sketch.markers["red"]
    mouse.choose_part("red")
    corner = before[0]
    mouse.drag(corner, corner + np.array((12, -9)))
    moved = corner + np.array((12, -9))
    wait_for(lambda: np.allclose(mouse.drawing.sketch.markers["red"][0], moved, atol=1.5))
    mouse.tab.keyboard.press("Control+z")
    wait_for(lambda: np.array_equal(mouse.drawing.sketch.markers["red"], before))
    middle = before.mean(axis=0)
    mouse.click(middle)
    wait_for(lambda: len(mouse.drawing.sketch.markers["red"]) == len(before) + 1)
    mouse.tab.keyboard.press("Delete")
    wait_for(lambda: len(mouse.drawing.sketch.markers["red"]) == len(before))
    assert np.array_equal(mouse.drawing.sketch.markers["red"], before)


def test_a_robot_is_turned_cleared_and_guessed(mouse):
    tab, drawing = mouse.tab, mouse.drawing
    names = tab.locator(".robsim-segments [role=radio]")

    def are_called(*expected):
        wait_for(lambda: names.all_text_contents() == ["Outline", *expected])

    are_called("Right marker (red)", "Left marker (blue)")
    # The arrow is dragged to where it faces
    angle = np.deg2rad(-mouse.tool._view._state()["alignment"])
    end = drawing.sketch.middle + 46 / mouse.scale * np.array((np.cos(angle), np.sin(angle)))
    mouse.drag(end, drawing.sketch.middle + np.array((60, 0)))
    wait_for(lambda: abs(drawing.sketch.alignment) < 2)
    are_called("Front marker (red)", "Back marker (blue)")
    tab.click("[name=as_before]")
    wait_for(lambda: drawing.sketch.alignment == load_robot("lab").alignment)
    tab.click("[name=clear]")
    wait_for(lambda: len(drawing.sketch.outline) == 0)
    problems = tab.locator(".robsim-problems")
    wait_for(lambda: "outline needs 3 corners" in problems.inner_text())
    assert tab.is_disabled("[name=save_robot]")
    tab.click("[name=guess]")
    wait_for(lambda: len(drawing.sketch.outline) > 5)


def test_two_points_of_known_distance_give_the_size(mouse):
    drawing, tab = mouse.drawing, mouse.tab
    tab.click("[name=ruler]")
    tab.wait_for_selector("text=Click two points")
    n_corners = len(drawing.sketch.outline)
    for point in ((100, 100), (100, 340)):
        mouse.click(point)
    tab.wait_for_selector("[name=ruler_length]:visible")
    tab.fill("[name=ruler_length]", "60")
    tab.keyboard.press("Enter")
    width = drawing.sketch.image.shape[1]
    wait_for(lambda: abs(drawing.sketch.size - 60 * width / 240) < 1)
    assert len(drawing.sketch.outline) == n_corners
