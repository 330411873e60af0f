"""The panel that trains colours, with the mouse and the keys, in Chromium."""

import numpy as np
import pytest

import robsim
from panel_mouse import ToolMouse
from robsim import ColorClass
from waiting import wait_for

pytestmark = pytest.mark.slow

RED, BLUE, FLOOR = (210, 40, 30), (30, 40, 210), (120, 122, 118)
#: The colour of a pixel of the canvas, by its place on the screen.
PIXEL = """([x, y]) => {
    const canvas = document.querySelector(".robsim-camera canvas");
    const ratio = canvas.width / canvas.getBoundingClientRect().width;
    const at = [Math.round(x * ratio), Math.round(y * ratio)];
    return [...canvas.getContext("2d").getImageData(...at, 1, 1).data];
}"""


@pytest.fixture
def image():
    image = np.full((120, 160, 3), FLOOR, np.uint8)
    image[40:60, 40:60] = RED
    image[40:60, 100:120] = BLUE
    return image


@pytest.fixture
def mouse(image, open_tool, tmp_path):
    with robsim.gui.color_panel(image, file=tmp_path / "colors.toml") as tool:
        yield Mouse(tool, open_tool(tool, theme="dark"))


class Mouse(ToolMouse):
    """The tool in a tab, as it is used with the mouse."""

    @property
    def classes(self):
        return {color.name: color for color in self.tool.value}

    @property
    def regions(self):
        """The regions of the red class."""
        trained = self.tool._view.training.classes.get("red")
        return [sample.region for sample in trained.samples] if trained else []


def test_a_region_by_keys(mouse, image):
    mouse.canvas.focus()
    for key in ("Enter", *["Shift+ArrowLeft"] * 3, *["ArrowUp"] * 6):
        mouse.tab.keyboard.press(key)

    wait_for(lambda: mouse.regions == [(47, 51, 53, 57)])
    assert mouse.classes["red"] == ColorClass.from_region(image, (47, 51, 53, 57), name="red")


def test_drags_are_undone_and_done_again_by_keys_and_buttons(mouse):
    tab = mouse.tab
    assert tab.is_disabled("[name=undo]")
    drags = (42, 42, 57, 57), (101, 42, 115, 57)
    for left, top, right, bottom in drags:
        mouse.drag((left, top), (right, bottom))
        wait_for(lambda drag=(left, top, right, bottom): mouse.regions == [drag])

    def does(press, key, *expected):
        press(key)
        wait_for(lambda: mouse.regions == [*expected])

    does(tab.keyboard.press, "Control+z", drags[0])
    does(tab.keyboard.press, "Control+z")
    tab.locator(".robsim-camera-hint").wait_for()
    tab.wait_for_selector("[name=undo]:disabled")
    does(tab.keyboard.press, "Control+Shift+Z", drags[0])
    does(tab.keyboard.press, "Control+y", drags[1])
    does(tab.click, "[name=undo]", drags[0])
    does(tab.click, "[name=redo]", drags[1])
    # A slider is no field to type in; in one the keys are its own
    tab.locator("[name=margin]").press("ArrowRight")
    wait_for(lambda: mouse.tool._view._state()["options"]["margin"] == 53)
    tab.keyboard.press("Control+z")
    wait_for(lambda: mouse.tool._view._state()["options"]["margin"] == 52)
    tab.fill("[name=new_class]", "blue")
    tab.keyboard.press("Control+z")
    does(tab.click, "[name=undo]", drags[0])


def test_the_thresholds_are_edited_as_text(mouse):
    text = mouse.tab.locator("[name=thresholds]")
    text.fill("[red]\nu = [3, 99]\n")
    text.press("Control+Enter")
    wait_for(lambda: mouse.classes.get("red") == ColorClass("red", u=(3, 99)))
    wait_for(lambda: "y = [0, 255]" in text.input_value())  # as Python writes it
    text.fill("[red\n")
    text.press("Control+Enter")
    mouse.tab.wait_for_selector(".robsim-toast-error")
    assert text.input_value() == "[red\n"  # to be mended
    mouse.tab.locator(".robsim-channel").nth(1).press("ArrowRight")
    wait_for(lambda: "u = [4, 99]" in text.input_value())


def test_a_region_is_of_its_class_and_comes_again_with_the_page(mouse):
    box = mouse.canvas.bounding_box()

    def is_framed():
        u, v = mouse.at((79.5, 85))  # between the first two columns: the left line is drawn there
        red, _, blue, _ = mouse.tab.evaluate(PIXEL, [u - box["x"], v - box["y"]])
        return red > blue + 60  # yellow

    mouse.tab.click("[name=tests]")
    with pytest.raises(ValueError, match="hardly any colour"):
        mouse.tool.train("red", (80, 80, 90, 90))
    mouse.tab.reload()
    mouse.tab.wait_for_selector("main[data-state]")
    wait_for(is_framed)
    mouse.tab.fill("[name=new_class]", "blue")
    mouse.tab.locator("[name=new_class]").press("Enter")
    wait_for(lambda: not is_framed())
    assert mouse.tab.locator(".robsim-camera-hint").is_visible()
    # The arrow keys lead from class to class; blue, which was never trained, is there no more
    mouse.tool.train("green", (100, 40, 119, 59))
    mouse.tab.click(".robsim-class[value=green]")
    mouse.tab.fill("[name=new_class]", "blue")
    mouse.tab.locator("[name=new_class]").press("Enter")
    mouse.tab.focus(".robsim-class[value=blue][aria-checked=true]")
    mouse.tab.keyboard.press("ArrowLeft")
    mouse.tab.locator(".robsim-class[value=blue]").wait_for(state="detached")
    assert mouse.tab.evaluate("document.activeElement.value") == "green"


def test_a_colour_is_seen_in_the_picture_narrowed_and_scored(mouse):
    tab = mouse.tab
    mouse.drag((42, 42), (57, 57))
    wait_for(lambda: "red" in mouse.classes)
    box = mouse.canvas.bounding_box()
    u, v = mouse.at((50, 50))
    inside = [u - box["x"], v - box["y"]]
    wait_for(lambda: tab.evaluate(PIXEL, inside)[0] > 235)  # painted red over the red
    tab.click("[name=tests]")
    wait_for(lambda: tab.evaluate(PIXEL, inside)[0] < 225)
    # The lower end of V is dragged
    low, high = mouse.classes["red"].v
    channel = tab.locator(".robsim-channel").nth(2)
    box = channel.bounding_box()
    y, level = box["y"] + box["height"] / 2, box["width"] / 256
    tab.mouse.move(box["x"] + low * level, y)
    tab.mouse.down()
    tab.mouse.move(box["x"] + (low + 30.5) * level, y, steps=5)
    tab.mouse.up()
    wait_for(lambda: abs(mouse.classes["red"].v[0] - (low + 30)) <= 1)
    assert mouse.classes["red"].v[1] == high
    # Other light and noise, and another region
    tab.click("[name=score]")
    tab.wait_for_selector(".robsim-score tr")
    tab.click("[name=more_regions]")
    mouse.drag((44, 44), (50, 50))
    wait_for(lambda: len(mouse.tool._view.training.classes["red"].samples) == 2)
    tab.click("[name=remove_class]")
    wait_for(lambda: mouse.classes == {})
