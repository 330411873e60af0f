"""The panel that trains colours, without a browser."""

import io
import threading
from contextlib import ExitStack

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser, settled
from python_cameras import PATIENT, SteppedCamera
from robsim import ColorClass
from robsim.imaging import save_image
from robsim.vision import classify, load_colors, save_colors
from waiting import wait_for

RED, BLUE, FLOOR = (210, 40, 30), (30, 40, 210), (120, 122, 118)


def picture(at=20):
    image = np.full((60, 80, 3), FLOOR, np.uint8)
    image[20:30, at : at + 10] = RED
    image[20:30, at + 30 : at + 40] = BLUE
    return image


@pytest.fixture
def view(tmp_path):
    with robsim.gui.color_panel(picture(), robot="lab", file=tmp_path / "colors.toml") as tool:
        yield tool._view


@pytest.fixture
def browser(view):
    return FakeBrowser(view, 80)


def mask_of(buffer):
    return np.array(Image.open(io.BytesIO(buffer)).convert("RGBA"))


def test_a_region_makes_a_class_that_is_shown_in_the_picture(view, browser):
    assert browser.take("setup")[0]["title"] == "a picture"
    assert browser.take("state")[0]["classes"] == []
    browser.take("frame")
    browser.say("region", region=[20, 20, 29, 29], keep=0)
    head, (counts,) = browser.take("histograms")
    assert head["region"] == [20, 20, 29, 29]
    assert np.frombuffer(counts, "<f4").reshape(3, 256).sum(axis=1).tolist() == [100] * 3
    state, _ = browser.take("state")
    made = ColorClass.from_region(picture(), (20, 20, 29, 29), name="red")
    assert view.training.value == (made,)
    assert state["classes"][0]["ranges"] == [[*made.y], [*made.u], [*made.v]]
    assert "[red]" in state["text"]
    head, (jpeg, mask) = browser.take("frame")
    assert Image.open(io.BytesIO(jpeg)).size == (80, 60)
    shown = mask_of(mask)
    np.testing.assert_array_equal(
        shown[..., 3] > 0, classify(picture(), [made], markers=view._markers)["red"]
    )
    assert shown[25, 25].tolist() == [255, 0, 0, 200]
    ((color, *box),) = head["boxes"]
    assert color == "red"
    np.testing.assert_allclose(box, (20, 20, 29, 29), atol=1)
    assert head["found"] is None
    assert "blue" in head["missed"]


def test_ranges_options_and_the_text_can_be_changed(view, browser):
    browser.say("region", region=[20, 20, 29, 29], keep=0)
    browser.say("ranges", ranges=[[0, 255], [0, 120], [180, 255]])
    browser.say("choose", name="blue")
    browser.say("region", region=[50, 20, 59, 29], keep=0)
    browser.say("set", name="margin", value=20)
    settled(view)
    red, blue = view.training.value
    assert red == ColorClass("red", u=(0, 120), v=(180, 255))
    assert blue == ColorClass.from_region(picture(), (50, 20, 59, 29), name="blue", margin=20)
    browser.say("thresholds", text="[red]\nu = [0, 99]\n")
    settled(view)
    assert view.training.value == (ColorClass("red", u=(0, 99)),)
    browser.say("remove")
    settled(view)
    assert view.training.value == (ColorClass("red", u=(0, 99)),)  # blue, which had been chosen


def test_what_is_wrong_is_said_and_changes_nothing(view):
    view.training.put(ColorClass("red", v=(200, 255)))
    for kind, fields, said in (
        ("region", {"region": [40, 0, 45, 9], "keep": 0}, "grey"),
        ("region", {"region": [70, 0, 99, 9], "keep": 0}, "region"),
        ("ranges", {"ranges": [[9, 3], [0, 9], [0, 9]]}, "y"),
        ("thresholds", {"text": "[red]\ny = [0, 300]"}, "within 0..255"),
        ("thresholds", {"text": "x" * 9000}, "a text of up to"),
        ("set", {"name": "nothing", "value": 5}, "'nothing'"),
        ("look", {"k": 3}, "picture 3"),
        ("save", {"file": "/dev/null/colors.toml"}, "/dev/null"),
    ):
        browser = FakeBrowser(view, 80)  # a line is not told of too many at once
        browser.say(kind, **fields)
        assert said in browser.take("note", level="error")[0]["text"]
        assert view.training.value == (ColorClass("red", v=(200, 255)),)


def test_a_recording_is_looked_through_and_trained_on(tmp_path):
    for k in range(3):
        save_image(tmp_path / f"{k}.png", picture(at=10 * k))
    with robsim.gui.color_panel(tmp_path, file=tmp_path / "colors.toml") as tool:
        browser = FakeBrowser(tool._view, 80)
        assert browser.take("setup")[0]["count"] == 3
        browser.say("region", region=[0, 20, 9, 29], keep=0)
        browser.say("look", k=2)
        browser.take("frame", k=2)
        browser.say("region", region=[20, 20, 29, 29], keep=1)
        settled(tool._view)
        samples = tool._view.training.classes["red"].samples
        assert [sample.picture for sample in samples] == ["frame 0", "frame 2"]


@pytest.mark.long
def test_a_camera_is_shown_live_until_it_is_frozen(tmp_path):
    source = SteppedCamera([picture(at=k) for k in range(10)])
    source.permits.release()  # the size is that of a frame
    with ExitStack() as stack:
        camera = stack.enter_context(robsim.Camera(source, **PATIENT))
        tool = stack.enter_context(robsim.gui.color_panel(camera, file=tmp_path / "colors.toml"))
        view = tool._view
        browser = FakeBrowser(view, 80)
        source.permits.release()
        first = browser.take("frame")[0]["name"]
        source.permits.release()
        assert browser.take("frame")[0]["name"] != first
        browser.say("freeze", on=True)
        browser.take("state", frozen=True)
        kept = view.picture
        source.permits.release()
        wait_for(lambda: view._taken is not kept)
        settled(view)
        assert view.picture is kept
        browser.say("freeze", on=False)
        settled(view)
        assert view.picture is view._taken
        tool.close()
        assert not [one for one in threading.enumerate() if one.name == "robsim pictures"]


def test_each_class_has_the_colour_that_it_is_painted_in(view, browser):
    view.training.replace([ColorClass("c1"), ColorClass("c2"), ColorClass("red")])
    colors = [one["css"] for one in view.state()["classes"]]
    assert len(set(colors)) == 3
    assert colors[2] == "rgb(255, 0, 0)"


def test_a_removed_class_leaves_the_file_and_others_stay(view, browser, tmp_path):
    save_colors(tmp_path / "colors.toml", ColorClass("kept"))
    browser.say("region", region=[20, 20, 29, 29], keep=0)
    browser.say("choose", name="blue")
    browser.say("region", region=[50, 20, 59, 29], keep=0)
    browser.say("save", file="")
    settled(view)
    assert load_colors(tmp_path / "colors.toml")[1:] == view.training.value
    browser.say("remove")
    browser.say("save", file="")
    settled(view)
    assert [one.name for one in load_colors(tmp_path / "colors.toml")] == ["kept", "red"]


def test_a_source_that_ends_says_why(tmp_path):
    sim = robsim.Simulation(area=(300, 300), seed=1)
    panel = robsim.panel(sim)
    with robsim.gui.color_panel(sim, file=tmp_path / "c.toml") as tool:
        browser = FakeBrowser(tool._view, 80)
        panel.close()
        browser.take("state", over="the panel of the run was closed", state="paused")
