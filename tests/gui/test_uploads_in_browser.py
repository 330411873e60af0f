"""Pictures from files into the tools, in Chromium: dropped, chosen, pasted; those that are bad."""

import threading

import numpy as np
import pytest

import robsim
from browsers import settled
from chromium_browser import drag_file
from robsim.vision import save_image
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
    drag_file(tab, plain, place.wait_for, at=(300, 300), drops=False)
    place.wait_for(state="hidden")
    assert is_painted(tab, FLOOR)
    drag_file(tab, plain, place.wait_for, at=(1200, 800))
    wait_for(lambda: is_painted(tab, PLAIN[0, 0]))
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
    bad.write_bytes(b"nothing")
    drag_file(tab, bad)
    tab.wait_for_selector(f"{REFUSED} >> text=bad.png is not in an image format")
    with open(bad, "wb") as file:
        file.truncate((64 << 20) + 10**6)
    drag_file(tab, bad)
    tab.wait_for_selector(f"{REFUSED} >> text=at most 64 MB are allowed")
    drag_file(tab, plain.parent)
    tab.wait_for_selector(f"{REFUSED} >> text=cannot be read")
    assert is_painted(tab, FLOOR)
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
    tab.click("[name=give_up]")
    tab.locator(GOING).wait_for(state="hidden")
    go_on.set()
    settled(view)
    wait_for(lambda: not view._uploads._coming)
    assert is_painted(tab, FLOOR)
    drag_file(tab, tmp_path / "noise.png")
    wait_for(lambda: view.picture.name == "noise.png")


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
