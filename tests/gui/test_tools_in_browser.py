"""The tools for floors and robots, with mouse and keys in Chromium."""

from itertools import islice

import numpy as np
import pytest

import robsim
from browsers import pixels_of_floor
from panel_mouse import ToolMouse
from robsim.lab import Chessboard
from robsim.vision import load_calibration, load_robot, save_image
from waiting import wait_for

pytestmark = pytest.mark.slow


# --- floors


PLACES = [(300, 300), (2100, 300), (2100, 2100), (300, 2100), (1200, 1200), (600, 1500)]
PIXELS = pixels_of_floor(np.array(PLACES, float))


class Hand(ToolMouse):
    """The tool in a tab, as it is used."""

    def __init__(self, tool, tab):
        super().__init__(tool, tab)
        self.glass = tab.locator(".robsim-glass-chosen")

    @property
    def points(self):
        return self.tool._view.points.draft.points

    def click(self, pixel):
        number = len(self.points) + 1
        super().click(pixel)
        wait_for(lambda: len(self.points) == number)
        self.tab.wait_for_selector(f"tr[aria-selected=true] input[name=x_{number}]")


@pytest.fixture
def hand(open_tool, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with robsim.gui.floor_panel() as tool:
        yield Hand(tool, open_tool(tool))


def test_a_floor_is_calibrated_and_saved(open_tool, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with robsim.gui.floor_panel() as tool:
        hand = Hand(tool, open_tool(tool, theme="dark"))
        tab = hand.tab
        problems = ".robsim-floor-result .robsim-problems"
        assert "place 4 points more" in tab.inner_text(problems)
        assert tab.is_disabled("[name=save_calibration]")
        for number, (pixel, (x, y)) in enumerate(zip(PIXELS, PLACES, strict=True), start=1):
            hand.click(np.add(pixel, (2, -1)))
            tab.keyboard.type(str(x))  # on the picture
            assert tab.evaluate("document.activeElement.name") == f"x_{number}"
            tab.keyboard.press("Enter")
            tab.keyboard.type(str(y))
            tab.keyboard.press("Enter")
            wait_for(lambda place=(x, y): hand.points[-1].place == place)
        found = np.array([one.pixel for one in hand.points])
        assert np.linalg.norm(found - PIXELS, axis=1).max() < 0.5  # on the corners
        tab.wait_for_selector(".robsim-floor-result .robsim-good")
        # A wrong place stands out at once
        tab.fill("[name=y_5]", "1400")
        tab.keyboard.press("Enter")
        wait_for(lambda: "point 5" in tab.inner_text(problems))
        hand.canvas.focus()
        tab.keyboard.press("Control+z")
        tab.wait_for_selector(".robsim-floor-result .robsim-good")
        tab.fill("[name=calibration_file]", "mine.toml")
        tab.click("[name=save_calibration]")
        tab.wait_for_selector(".robsim-toast:has-text('mine.toml')")
        saved = load_calibration("mine.toml")
        np.testing.assert_allclose(2 * saved.plane_map.to_world(PIXELS), PLACES, atol=3)


def test_a_point_is_placed_dragged_nudged_chosen_and_removed(hand):
    tab = hand.tab

    def fill(name, text):
        tab.fill(f"[name={name}]", text)
        tab.keyboard.press("Enter")

    hand.click(PIXELS[0])
    tab.fill("[name=x_1]", "300")
    fill("y_1", "400")
    wait_for(lambda: hand.points[0].place == (300, 400))
    fill("x_1", "3oo")  # is marked and changes nothing
    tab.wait_for_selector("[name=x_1][aria-invalid=true]")
    fill("x_1", "")
    wait_for(lambda: hand.points[0].place == (None, 400))
    tab.click("[name=clear]")
    tab.wait_for_selector("[name=x_1]", state="detached")  # else the page takes hold of it
    assert hand.points == ()
    hand.click(PIXELS[0])
    hand.click(PIXELS[4])
    start = np.array(hand.points[1].pixel)
    hand.drag(start, np.add(start, (20, 10)))
    wait_for(lambda: np.allclose(hand.points[1].pixel, np.add(start, (20, 10)), atol=1))
    before = np.array(hand.points[1].pixel)
    hand.canvas.focus()
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("Shift+ArrowUp")
    wait_for(lambda: np.allclose(hand.points[1].pixel, np.add(before, (0.2, -1))))
    for _ in range(4):
        tab.keyboard.press("Control+z")
    wait_for(lambda: np.allclose(hand.points[1].pixel, start))
    tab.keyboard.press("s")
    wait_for(lambda: tuple(hand.points[1].pixel) != tuple(start))
    assert hand.points[1].pixel == pytest.approx(tuple(PIXELS[4]), abs=0.5)
    tab.keyboard.press("Shift+Tab")
    tab.wait_for_selector("tr[aria-selected=true] input[name=x_1]")
    tab.keyboard.press("Delete")
    wait_for(lambda: [one.number for one in hand.points] == [2])
    tab.click("[name=clear]")
    wait_for(lambda: hand.points == ())


def test_in_the_glass_a_point_is_moved_by_parts_of_a_pixel(hand):
    tab = hand.tab
    tab.click("[name=snap]")
    hand.click(PIXELS[0])
    start = np.array(hand.points[0].pixel)
    box = hand.glass.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.move(*middle)
    tab.mouse.down()
    tab.mouse.move(middle[0] + 4, middle[1] - 12, steps=4)
    tab.mouse.up()
    wait_for(lambda: np.allclose(hand.points[0].pixel, np.add(start, (0.5, -1.5))))
    tab.wait_for_selector(f"text=v {hand.points[0].pixel[1]:.2f}")
    hand.glass.focus()
    tab.keyboard.press("ArrowDown")
    wait_for(lambda: np.allclose(hand.points[0].pixel, np.add(start, (0.5, -1.4))))


def test_sheets_are_found(open_tool, tmp_path, monkeypatch):
    pytest.importorskip("cv2")
    from photographed_sheets import OBLIQUE, floor_picture

    monkeypatch.chdir(tmp_path)
    with robsim.gui.floor_panel(floor_picture(OBLIQUE)) as tool:
        hand = Hand(tool, open_tool(tool))
        hand.tab.click(".robsim-segments [value=sheets]")
        hand.tab.click("[name=find_sheets]")
        hand.tab.wait_for_selector("[name=sheet_x_5]")
        hand.tab.fill("[name=sheet_x_1]", "500")
        hand.tab.fill("[name=sheet_y_1]", "400")
        hand.tab.keyboard.press("Tab")
        wait_for(lambda: tool._view.sheets.task().places == {1: (500, 400)})


def test_a_lens_is_taken_and_used(open_tool, tmp_path, monkeypatch):
    pytest.importorskip("cv2")
    from photographed_sheets import board_pictures

    monkeypatch.chdir(tmp_path)
    (tmp_path / "film").mkdir()
    for number, image in enumerate(islice(board_pictures(Chessboard(9, 6)), 5)):
        save_image(tmp_path / "film" / f"{number}.png", image)
    with robsim.gui.floor_panel("film") as tool:
        hand = Hand(tool, open_tool(tool))
        tab = hand.tab
        tab.click(".robsim-segments [value=lens]")
        tab.wait_for_selector("text=take 4 pictures more")
        assert tab.is_disabled("[name=use_lens]")
        tab.click("[name=take_all_boards]")
        tab.wait_for_selector("text=5 pictures, rms")
        tab.click("[name=use_lens]")
        tab.wait_for_selector("text=The lens is calibrated")
        assert tool.value.intrinsics is not None
        assert tab.is_enabled("[name=save_calibration]")  # without a floor
        tab.click("[name=drop_boards]")
        tab.wait_for_selector("text=take 4 pictures more")
        tab.fill("[name=board_columns]", "8")
        tab.keyboard.press("Enter")
        wait_for(lambda: tool._view.lens.board.columns == 8)


# --- robots


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
    mouse.click(corner)
    mouse.tab.keyboard.press("ArrowRight")  # of the screen: the picture is turned by 90 degrees
    wait_for(lambda: np.allclose(mouse.drawing.sketch.markers["red"][0] - corner, (0, -1)))
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
    wait_for(lambda: "outline needs at least 3 corners" in problems.inner_text())
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
