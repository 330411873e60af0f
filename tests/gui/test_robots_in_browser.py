"""The panel that defines a robot, with the mouse and the keys, in Chromium."""

import numpy as np
import pytest

import robsim
from panel_mouse import ToolMouse
from robsim.robots import load_robot
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
    end = drawing.centre + 46 / mouse.scale * np.array((np.cos(angle), np.sin(angle)))
    mouse.drag(end, drawing.centre + np.array((60, 0)))
    wait_for(lambda: abs(drawing.sketch.alignment) < 2)
    are_called("Front marker (red)", "Back marker (blue)")
    tab.click("text=+10°")
    wait_for(lambda: abs(drawing.sketch.alignment - 10) < 2)
    tab.click("[name=as_before]")
    wait_for(lambda: drawing.sketch.alignment == load_robot("lab").alignment)
    tab.click("[name=clear]")
    wait_for(lambda: len(drawing.sketch.outline) == 0)
    problems = tab.locator(".robsim-problems")
    wait_for(lambda: "outline needs 3 corners" in problems.inner_text())
    assert tab.is_disabled("[name=save_robot]")
    tab.click("[name=guess]")
    wait_for(lambda: len(drawing.sketch.outline) > 5)
    mouse.canvas.focus()
    tab.keyboard.press("Enter")
    wait_for(lambda: mouse.tool._view._part == "red")
    mouse.tool.draw("blue", [])
    are_called("Marker (red)", "Marker (blue)")


def test_another_robot_is_loaded_resized_and_saved(mouse):
    mouse.tab.select_option("[name=robot]", "robot2")
    wait_for(lambda: mouse.tool._view.name == "robot2")
    mouse.tab.fill("[name=robot_size]", "150")
    mouse.tab.press("[name=robot_size]", "Tab")
    wait_for(lambda: mouse.drawing.sketch.size == 150)
    mouse.tab.fill("[name=robot_name]", "mine")
    mouse.tab.click("[name=save_robot]")
    wait_for(lambda: "mine" in robsim.robots.robot_names())
    assert load_robot("mine").size == 150
    mouse.tab.click("text=+10°")
    mouse.tab.fill("[name=robot_name]", "mine")
    mouse.tab.click("[name=save_robot]:has-text('Replace')")
    wait_for(lambda: load_robot("mine").alignment == mouse.drawing.sketch.alignment)
    mouse.tab.fill("[name=robot_name]", "lab")
    mouse.tab.click("[name=save_robot]")
    mouse.tab.wait_for_selector(".robsim-toast-error")


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
    mouse.drag((100, 340), (100, 220))
    wait_for(lambda: abs(drawing.sketch.size - 60 * width / 120) < 2)
    tab.keyboard.press("Escape")
    tab.click("[name=ruler]")
    assert len(drawing.sketch.outline) == n_corners


def test_a_frame_of_a_recording_is_chosen_and_captured(open_tool, user_folder, tmp_path):
    for k in range(3):
        start = (100 + 100 * k, 200, 0)
        sim = robsim.Simulation(robot="lab", area=(400, 400), start=start, seed=k)
        frame = sim.step().frame
        robsim.imaging.save_image(tmp_path / f"{k}.png", frame.image)
    with robsim.gui.robot_panel(tmp_path, robot="sheep") as tool:
        tab = open_tool(tool)
        tab.fill("input[type=range][name=picture]", "2")
        wait_for(lambda: tool._view.picture.k == 2)
        tab.click("[name=capture]")
        tab.wait_for_selector("[name=resume]:visible")
        assert not tab.is_visible("input[type=range][name=picture]")
        tab.click("[name=resume]")
        wait_for(lambda: tool._view.picture.k == 2)


def test_a_square_of_a_simulation_is_captured(open_tool, user_folder):
    sim = robsim.Simulation(robot="lab", start=(400, 500, 0.6), headings=None, seed=2)
    with robsim.gui.robot_panel(sim, robot="sheep") as tool:
        mouse = ToolMouse(tool, open_tool(tool, theme="dark"))
        u, v, side = tool._view._square
        mouse.drag((u, v), (400, 500))
        wait_for(lambda: np.allclose(tool._view._square[:2], (400, 500), atol=2))
        u, v, side = tool._view._square
        mouse.tab.wait_for_selector(f"text=around ({u:.0f}, {v:.0f})")
        corner = np.array((400 + side / 2, 500 + side / 2))
        mouse.drag(corner, (400 + 90, 500 + 90))
        wait_for(lambda: abs(tool._view._square[2] - 180) < 5)
        mouse.tab.click("[name=capture]")
        wait_for(lambda: tool._view._state()["mode"] == "draw")
        assert tool._view.drawing.problems() == []
        mouse.tab.click("[name=resume]")
        wait_for(lambda: tool._view._state()["mode"] == "capture")
