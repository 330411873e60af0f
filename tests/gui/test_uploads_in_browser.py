"""Pictures from files into the tools, in Chromium: dropped, chosen, pasted; those that are bad."""

import threading

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import settled
from drops import drag_file
from robsim import ColorClass
from robsim.imaging import save_image
from robsim.robots import load_robot
from waiting import wait_for

pytestmark = pytest.mark.slow

FLOOR = (120, 122, 118)
PLAIN = np.full((90, 120, 3), (40, 160, 60), np.uint8)
#: The colour of the middle of the picture.
MIDDLE = """() => {
    const canvas = document.querySelector(".robsim-camera canvas");
    const at = [Math.round(canvas.width / 2), Math.round(canvas.height / 2)];
    return [...canvas.getContext("2d").getImageData(...at, 1, 1).data.slice(0, 3)];
}"""
REFUSED = ".robsim-load-refused"
GOING = ".robsim-load-going"


def is_painted(tab, color):
    return np.abs(np.subtract(tab.evaluate(MIDDLE), color)).max() < 12


def choose(tab, file):
    tab.set_input_files("input[name=picture]", file)


@pytest.fixture
def plain(tmp_path):
    save_image(tmp_path / "plain.png", PLAIN)
    return tmp_path / "plain.png"


@pytest.fixture
def tool(tmp_path):
    floor = np.full((120, 160, 3), FLOOR, np.uint8)
    with robsim.gui.color_panel(floor, file=tmp_path / "colors.toml") as tool:
        yield tool


def test_a_file_is_dropped_anywhere_on_the_tool(tool, open_tool, plain):
    tab = open_tool(tool, theme="dark")
    place = tab.locator(".robsim-drop")
    for at in ((300, 300), (1200, 800)):
        drag_file(tab, plain, place.wait_for, at=at, drops=False)
        place.wait_for(state="hidden")
    assert is_painted(tab, FLOOR)
    drag_file(tab, plain, place.wait_for, at=(1200, 800))
    wait_for(lambda: is_painted(tab, PLAIN[0, 0]))
    assert place.is_hidden()
    assert tab.inner_text(".robsim-tool-source") == "plain.png"
    tab.click("[name=back]")
    wait_for(lambda: is_painted(tab, FLOOR))
    tab.locator("[name=back]").wait_for(state="hidden")


def test_a_file_is_chosen_with_the_keys_and_a_picture_is_pasted(tool, open_tool, plain):
    tab = open_tool(tool)
    tab.on("filechooser", lambda _: None)  # so that Playwright takes all of them
    for _ in range(2):  # the same one again
        tab.focus("[name=load_picture]")
        with tab.expect_file_chooser() as chooser:
            tab.keyboard.press("Enter")
        chooser.value.set_files(plain)
        wait_for(lambda: is_painted(tab, PLAIN[0, 0]))
        tab.focus("[name=back]")
        tab.keyboard.press("Enter")
        wait_for(lambda: is_painted(tab, FLOOR))
    tab.evaluate(
        """(bytes) => {
            const clipboardData = new DataTransfer();
            clipboardData.items.add(new File([new Uint8Array(bytes)], "seen.png"));
            document.body.dispatchEvent(
                new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
        }""",
        [*plain.read_bytes()],
    )
    wait_for(lambda: is_painted(tab, PLAIN[0, 0]))


def test_a_bad_file_gets_a_sentence_in_place_until_a_good_one_comes(tool, open_tool, plain):
    tab = open_tool(tool)
    refused = tab.locator(REFUSED)
    bad = plain.with_name("bad.png")
    for content, said in {
        b"nothing": "bad.png is not in an image format",
        plain.read_bytes()[:90]: "bad.png cannot be read as an image",
        b"": "bad.png is empty",
    }.items():
        bad.write_bytes(content)
        drag_file(tab, bad)
        tab.wait_for_selector(f"{REFUSED} >> text={said}")
    with open(bad, "wb") as file:
        file.truncate((64 << 20) + 10**6)
    drag_file(tab, bad)
    tab.wait_for_selector(f"{REFUSED} >> text=at most 64 MB are taken")
    drag_file(tab, plain.parent)
    tab.wait_for_selector(f"{REFUSED} >> text=cannot be read")
    assert tab.locator(".robsim-toast").count() == 0
    refused.locator("button").click()
    refused.wait_for(state="hidden")
    assert is_painted(tab, FLOOR)
    drag_file(tab, bad)
    refused.wait_for()
    drag_file(tab, plain)
    wait_for(lambda: is_painted(tab, PLAIN[0, 0]))
    refused.wait_for(state="hidden")


def test_a_large_file_shows_how_far_it_is_and_can_be_given_up(tool, open_tool, tmp_path):
    noise = np.random.default_rng(3).integers(0, 256, (700, 700, 3)).astype(np.uint8)
    save_image(tmp_path / "noise.png", noise)
    assert (tmp_path / "noise.png").stat().st_size > 1 << 20
    tab = open_tool(tool)
    view, go_on = tool._view, threading.Event()
    take, taken = view._uploads.take, []

    def take_one(link, message):
        taken.append(message["at"])
        if len(taken) == 2:
            go_on.wait(300)
        take(link, message)

    view._uploads.take = take_one
    drag_file(tab, tmp_path / "noise.png")
    tab.wait_for_selector(f"{GOING} >> text=/noise.png: (3|4)\\d %/")
    assert 0.3 < tab.locator(f"{GOING} progress").evaluate("bar => bar.value") < 0.5
    tab.click("[name=give_up]")
    tab.locator(GOING).wait_for(state="hidden")
    go_on.set()
    settled(view)
    wait_for(lambda: not view._uploads._coming)
    assert is_painted(tab, FLOOR)
    drag_file(tab, tmp_path / "noise.png")
    wait_for(lambda: view.picture.name == "noise.png")


def test_a_live_picture_comes_back(open_tool, plain, tmp_path):
    sim = robsim.Simulation(area=(300, 300), robot="lab", seed=1)
    with robsim.gui.color_panel(sim, file=tmp_path / "c.toml") as tool:
        tab = open_tool(tool)
        drag_file(tab, plain)
        wait_for(lambda: is_painted(tab, PLAIN[0, 0]))
        assert tab.locator("[name=freeze]").is_hidden()
        tab.click("text=Back to the live picture")
        wait_for(lambda: not is_painted(tab, PLAIN[0, 0]))
        tab.wait_for_selector("[name=freeze]")


def test_a_robot_of_a_file_is_drawn_on_or_captured(open_tool, user_folder, tmp_path):
    lab = load_robot("lab")
    Image.fromarray(np.array(lab.image)).save(tmp_path / "seen.png")
    sim = robsim.Simulation(robot="lab", start=(300, 300, 0.6), area=(600, 600), seed=2)
    save_image(tmp_path / "photo.jpg", sim.step().frame.image)
    with robsim.gui.robot_panel(robot="sheep") as tool:
        tab = open_tool(tool)
        choose(tab, tmp_path / "seen.png")
        tab.wait_for_selector(".robsim-tool-source >> text=seen")
        assert tool.value.image.shape == lab.image.shape
        choose(tab, tmp_path / "photo.jpg")
        tab.wait_for_selector("[name=capture]")
        tab.click("text=Back to the drawing")
        tab.wait_for_selector("[name=resume]")
        assert tool.value.image.shape == lab.image.shape
        tab.click("[name=resume]")
        tab.click("[name=capture]")
        tab.wait_for_selector("[name=resume]")
        assert tool.value.image.shape[:2] == (240, 240)
        tab.click("[name=resume]")
        tab.click("[name=capture_whole]")
        wait_for(lambda: tool._view.drawing.sketch.image.shape[:2] == (600, 600))


def test_a_panel_that_takes_no_files_refuses_them(open_panel, plain):
    # Where nobody prevents it, the browser shows the file in place of the page.
    _, tab = open_panel(robsim.Simulation(area=(300, 300), seed=1))
    tab.evaluate(
        """() => {
            window.drags = [];
            for (const type of ["dragover", "drop"])
                addEventListener(type, (event) =>
                    drags.push([type, event.defaultPrevented, event.dataTransfer.dropEffect]));
        }"""
    )
    for at in ((300, 300), (1200, 800)):
        drag_file(tab, plain, at=at)
    wait_for(lambda: tab.evaluate("drags.length") >= 2)
    assert {tuple(drag) for drag in tab.evaluate("drags")} == {("dragover", True, "none")}
    is_taken = tab.evaluate(
        """() => {
            const dataTransfer = new DataTransfer();
            dataTransfer.items.add(new File([], "beside"));
            return document.body.dispatchEvent(
                new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
        }"""
    )
    assert is_taken is False
    assert tab.locator(".robsim-toast").count() == 0


def test_twelve_megapixels(open_tool, tmp_path):
    pixels = np.full((3000, 4000, 3), FLOOR, np.uint8)
    pixels[1500:1700, 900:1100] = (210, 40, 30)
    Image.fromarray(pixels).save(tmp_path / "large.jpg", quality=92)
    with robsim.gui.color_panel(PLAIN, file=tmp_path / "c.toml") as tool:
        tab = open_tool(tool)
        drag_file(tab, tmp_path / "large.jpg")
        wait_for(lambda: tool._view.picture.frame.image.shape == (3000, 4000, 3))
        image = tool._view.picture.frame.image
        region = (950, 1550, 1050, 1650)
        tool.train("red", region)
        assert tool.value == (ColorClass.from_region(image, region, name="red"),)
