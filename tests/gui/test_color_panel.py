"""`robsim.gui.color_panel`, as users and scripts have it."""

import io
import threading

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser
from robsim import ColorClass
from robsim.imaging import save_image
from robsim.vision import load_colors
from waiting import wait_for

RED, BLUE, FLOOR = (210, 40, 30), (30, 40, 210), (120, 122, 118)
REGION = (20, 20, 29, 29)


@pytest.fixture
def picture():
    image = np.full((60, 80, 3), FLOOR, np.uint8)
    image[20:30, 20:30] = RED
    image[20:30, 50:60] = BLUE
    return image


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_what_the_mouse_does_is_done_by_a_script(picture):
    with robsim.gui.color_panel(picture, file="mine.toml") as tool:
        made = tool.train("red", REGION)
        assert made == ColorClass.from_region(picture, REGION, name="red")
        assert tool.value == (made,)
        tool.train("red", (25, 25, 29, 29), more=True)
        assert len(tool._view.training.classes["red"].samples) == 2
        blue = ColorClass("blue", u=(160, 255))
        tool.value = [*tool.value, blue]
        assert tool.value[1] == blue
        assert tool.save().name == "mine.toml"
        assert load_colors("mine.toml") == tool.value
        with pytest.raises(ValueError, match="region"):
            tool.train("red", (0, 0, 99, 9))
    with pytest.raises(RuntimeError, match="is closed"):
        tool.train("red", REGION)
    assert len(tool.value) == 2  # what was made is still there


def test_it_begins_with_what_the_file_has(picture):
    robsim.vision.save_colors("colors.toml", ColorClass("green", v=(1, 100)))
    with robsim.gui.color_panel(picture) as tool:
        assert tool.value == (ColorClass("green", v=(1, 100)),)
    with robsim.gui.color_panel(picture, colors=[ColorClass("pink")]) as tool:
        assert [color.name for color in tool.value] == ["pink"]


def test_whose_pictures_it_shows(picture, tmp_path):
    (tmp_path / "film").mkdir()
    for k in range(2):
        save_image(tmp_path / "film" / f"{k}.png", picture)
    save_image("photo.png", picture)
    sim = robsim.Simulation(area=(300, 300), measure=True, seed=1)
    recording = robsim.Recording(tmp_path / "film")
    for what in ("photo.png", robsim.Frame(picture), recording, tmp_path / "film", sim):
        with robsim.gui.color_panel(what) as tool:
            head, _ = FakeBrowser(tool._view, 80).take("frame")
            assert head["size"] == ([300, 300] if what is sim else [80, 60])
            if what == tmp_path / "film":
                tool.look(1)
                assert tool._view.picture.k == 1
    assert sim.step().k == 0  # nobody drives it any more


def test_a_panel_that_was_open_stays_open():
    sim = robsim.Simulation(area=(300, 300), measure=True, seed=1)
    with robsim.panel(sim) as panel:
        with robsim.gui.color_panel(sim) as tool:
            browser = FakeBrowser(tool._view, 80)
            panel.step()
            browser.take("frame", k=0)
        panel.step()
        assert len(panel.trace) == 2


@pytest.mark.long
def test_a_picture_of_12_megapixels_is_sent_in_few():
    image = np.full((3000, 4000, 3), FLOOR, np.uint8)
    image[1500:1700, 900:1100] = RED
    with robsim.gui.color_panel(image) as tool:
        tool.train("red", (910, 1510, 1090, 1690))
        wait_for(lambda: tool._view.picture is not None)
        _, (mask,) = tool._view.head(tool._view.picture)
        shown = np.asarray(Image.open(io.BytesIO(mask)).convert("RGBA"))[..., 3] > 0
        rows, columns = np.nonzero(shown)
        step = round(4000 / shown.shape[1])
        assert max(shown.shape) <= 1600
        np.testing.assert_allclose([step * rows.min(), step * rows.max()], (1500, 1699), atol=step)
        np.testing.assert_allclose(
            [step * columns.min(), step * columns.max()], (900, 1099), atol=step
        )


def test_the_picture_of_the_robot_shows_the_robot():
    with robsim.gui.color_panel(robot="lab", colors=load_colors()) as tool:
        head, _ = FakeBrowser(tool._view, 80).take("frame")
        assert head["missed"] is None
        assert head["found"] is not None


def test_other_light_and_noise(picture):
    with robsim.gui.color_panel(picture) as tool:
        browser = FakeBrowser(tool._view, 80)
        browser.say("score")
        assert "mark a region" in browser.take("note", level="error")[0]["text"]
        tool.train("red", REGION)
        browser.say("score")
        score, _ = browser.take("score")
        assert score["name"] == "red"
        assert 0.5 < score["rate"] <= 1
        assert {sweep["name"] for sweep in score["levels"]} >= {"brightness", "shadow"}


def test_what_is_wrong_is_refused_by_its_name():
    threads = threading.active_count()
    for arguments, said in (
        ({"what": 3}, "what must"),
        ({"what": "none.png"}, "none.png"),
        ({"colors": 3}, "colors must"),
        ({"robot": "nobody"}, "nobody"),
    ):
        with pytest.raises((TypeError, ValueError, OSError), match=said):
            robsim.gui.color_panel(**arguments)
    assert threading.active_count() == threads
