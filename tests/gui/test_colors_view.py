"""The panel that trains colours, without a browser: messages, methods, and the classes."""

import io
import sys
import threading
from contextlib import ExitStack

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import FakeBrowser, settled
from python_devices import PATIENT, SteppedCamera
from robsim import ColorClass
from robsim.base.text import one_line
from robsim.gui.tools.colors.training import ColorTraining
from robsim.gui.tools.pictures import OnePicture
from robsim.vision import classify, color_histograms, load_colors, save_colors, save_image
from waiting import wait_for

RED, BLUE, FLOOR = (210, 40, 30), (30, 40, 210), (120, 122, 118)


def picture(at=20):
    image = np.full((60, 80, 3), FLOOR, np.uint8)
    image[20:30, at : at + 10] = RED
    image[20:30, at + 30 : at + 40] = BLUE
    return image


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder, in which the tools look for files of colours."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


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
    browser.say("region", region=[20, 20, 29, 29], keep=0, goes_on=False)
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
    browser.say("region", region=[20, 20, 29, 29], keep=0, goes_on=False)
    browser.say("ranges", ranges=[[0, 255], [0, 120], [180, 255]], goes_on=False)
    browser.say("choose", name="blue")
    browser.say("region", region=[50, 20, 59, 29], keep=0, goes_on=False)
    browser.say("set", name="margin", value=20, goes_on=False)
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


def test_changes_are_undone_and_a_drag_is_one(view, browser):
    def value(*said):
        for kind, fields in said:
            browser.say(kind, **fields)
        settled(view)
        state = view._state()
        return view.training.value, state["region"], state["can_undo"], state["can_redo"]

    def region(*sides, goes_on=False):
        return "region", {"region": [*sides], "keep": 0, "goes_on": goes_on}

    def margin(value, goes_on=False):
        return "set", {"name": "margin", "value": value, "goes_on": goes_on}

    undo, redo = ("undo", {}), ("redo", {})
    made = ColorClass.from_region(picture(), (20, 20, 27, 27), name="red")
    value(region(20, 20, 29, 29), region(20, 20, 27, 27, goes_on=True))
    value(margin(20), margin(10, goes_on=True))
    assert value(undo) == ((made,), [20, 20, 27, 27], True, True)
    assert value(undo) == ((), None, False, True)
    assert value(redo) == ((made,), [20, 20, 27, 27], True, True)
    # A drag is a separate change, too, if its beginning is refused
    changed = value(region(40, 0, 45, 9), region(50, 20, 59, 29, goes_on=True))
    assert changed[0] != (made,)
    assert value(undo) == ((made,), [20, 20, 27, 27], True, True)


def test_what_is_wrong_is_said_and_changes_nothing(view):
    view.training.put(ColorClass("red", v=(200, 255)))
    for kind, fields, said in (
        ("region", {"region": [40, 0, 45, 9], "keep": 0, "goes_on": False}, "grey"),
        ("region", {"region": [70, 0, 99, 9], "keep": 0, "goes_on": False}, "region"),
        ("region", {"region": [70, 0, 99], "keep": 0, "goes_on": False}, "region"),
        ("ranges", {"ranges": [[9, 3], [0, 9], [0, 9]], "goes_on": False}, "y"),
        ("thresholds", {"text": "[red]\ny = [0, 300]"}, "within 0..255"),
        ("thresholds", {"text": "x" * 9000}, "a text of up to"),
        ("set", {"name": "nothing", "value": 5, "goes_on": False}, "'nothing'"),
        ("look", {"k": 3}, "picture 3"),
        ("save", {"file": "/dev/null/colors.toml"}, "/dev/null"),
        ("save", {"file": ".bash_profile"}, "must end in .toml"),
        ("save", {"file": "colors.sh"}, "must end in .toml"),
        ("save", {"file": ".colors.toml"}, "begin with a letter"),
    ):
        browser = FakeBrowser(view, 80)  # a line is not told of too many at once
        browser.say(kind, **fields)
        assert said in browser.take("note", level="error")[0]["text"]
        assert view.training.value == (ColorClass("red", v=(200, 255)),)


@pytest.mark.parametrize(
    ("name", "target"),
    [
        *(
            (name, None)
            for name in ("new/c.toml", "$(id).toml", "-rf.toml", "a\nb.toml", "\x1b.toml")
        ),
        ("profile.toml", ".bash_profile"),
        ("hidden.toml", ".hidden.toml"),
        ("without.toml", "without"),
        ("folder.toml", "new/c.toml"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="no such names")
def test_a_page_writes_no_file_of_another_kind(view, tmp_path, name, target):
    view.training.put(ColorClass("red", v=(200, 255)))
    if target:
        (tmp_path / name).symlink_to(target)
    browser = FakeBrowser(view, 80)
    browser.say("save", file=str(tmp_path / name))
    assert one_line(name) in browser.take("note", level="error")[0]["text"]
    assert [file.name for file in tmp_path.iterdir()] == ([name] if target else [])


def test_a_recording_is_looked_through_and_trained_on(tmp_path):
    for k in range(3):
        save_image(tmp_path / f"{k}.png", picture(at=10 * k))
    with robsim.gui.color_panel(tmp_path, file=tmp_path / "colors.toml") as tool:
        browser = FakeBrowser(tool._view, 80)
        assert browser.take("setup")[0]["count"] == 3
        browser.say("region", region=[0, 20, 9, 29], keep=0, goes_on=False)
        browser.say("look", k=2)
        browser.take("frame", k=2)
        browser.say("region", region=[20, 20, 29, 29], keep=1, goes_on=False)
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


def test_options_count_for_a_class_that_is_not_there_yet(view, browser):
    browser.say("set", name="limit_y", value=True, goes_on=False)
    browser.say("region", region=[40, 0, 45, 9], keep=0, goes_on=False)
    settled(view)
    (made,) = view.training.value
    grey = ColorClass.from_region(picture(), (40, 0, 45, 9), name=made.name, limit_y=True)
    assert made == grey


def test_a_camera_that_is_closed_says_so(here):
    save_image("0.png", picture())
    camera = robsim.Camera(here, fps=100)
    camera.close()
    with robsim.gui.color_panel(camera) as tool:
        wait_for(lambda: "closed" in tool._view._over)


def test_a_removed_class_leaves_the_file_and_others_stay(view, browser, tmp_path):
    save_colors(tmp_path / "colors.toml", ColorClass("kept"))
    browser.say("region", region=[20, 20, 29, 29], keep=0, goes_on=False)
    browser.say("choose", name="blue")
    browser.say("region", region=[50, 20, 59, 29], keep=0, goes_on=False)
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


REGION = (20, 20, 29, 29)


def test_what_the_mouse_does_is_done_by_a_script(here):
    with robsim.gui.color_panel(picture(), file="mine.toml") as tool:
        with pytest.raises(ValueError, match="no colours yet"):
            tool.save()
        made = tool.train("red", REGION)
        assert made == ColorClass.from_region(picture(), REGION, name="red")
        assert tool.value == (made,)
        tool.train("red", (25, 25, 29, 29), more=True)
        assert len(tool._view.training.classes["red"].samples) == 2
        blue = ColorClass("blue", u=(160, 255))
        tool.value = [*tool.value, blue]
        assert tool.value[1] == blue
        assert tool.save().name == "mine.toml"
        assert load_colors("mine.toml") == tool.value
        for call, said in (
            (lambda: tool.train("red", (0, 0, 99, 9)), "region"),
            (lambda: tool.look(0), "k must"),
        ):
            with pytest.raises(ValueError, match=said):
                call()
    with pytest.raises(RuntimeError, match="is closed"):
        tool.train("red", REGION)
    assert len(tool.value) == 2  # what was made is still there


def test_it_begins_with_what_the_file_has(here):
    robsim.vision.save_colors("colors.toml", ColorClass("green", v=(1, 100)))
    with robsim.gui.color_panel(picture()) as tool:
        assert tool.value == (ColorClass("green", v=(1, 100)),)
    with robsim.gui.color_panel(picture(), colors=[ColorClass("pink")]) as tool:
        assert [color.name for color in tool.value] == ["pink"]


def test_whose_pictures_it_shows(here):
    (here / "film").mkdir()
    for k in range(2):
        save_image(here / "film" / f"{k}.png", picture())
    save_image("photo.png", picture())
    sim = robsim.Simulation(area=(300, 300), measure=True, seed=1)
    recording = robsim.Recording(here / "film")
    for what in ("photo.png", robsim.Frame(picture()), recording, here / "film", sim):
        with robsim.gui.color_panel(what) as tool:
            head, _ = FakeBrowser(tool._view, 80).take("frame")
            assert head["size"] == ([300, 300] if what is sim else [80, 60])
            if what == here / "film":
                tool.look(1)
                assert tool._view.picture.k == 1
    assert sim.step().k == 0  # nobody drives it any more


def test_a_panel_that_was_open_stays_open(here):
    sim = robsim.Simulation(area=(300, 300), measure=True, seed=1)
    with robsim.panel(sim) as panel:
        with robsim.gui.color_panel(sim) as tool:
            browser = FakeBrowser(tool._view, 80)
            panel.step()
            browser.take("frame", k=0)
        panel.step()
        assert len(panel.trace) == 2


@pytest.mark.long
def test_a_picture_of_12_megapixels_is_sent_in_few(here):
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


def test_the_picture_of_the_robot_shows_the_robot(here):
    with robsim.gui.color_panel(robot="lab", colors=load_colors()) as tool:
        head, _ = FakeBrowser(tool._view, 80).take("frame")
        assert head["missed"] is None
        assert head["found"] is not None


def test_other_light_and_noise(here):
    with robsim.gui.color_panel(picture()) as tool:
        browser = FakeBrowser(tool._view, 80)
        browser.say("score")
        assert "mark a region" in browser.take("note", level="error")[0]["text"]
        tool.train("red", REGION)
        browser.say("score")
        score, _ = browser.take("score")
        assert score["name"] == "red"
        assert 0.5 < score["rate"] <= 1
        assert {sweep["name"] for sweep in score["levels"]} >= {"brightness", "shadow"}
        smaller = OnePicture(picture()[:15, :15], "smaller").at(0)
        tool._view.ask(lambda: tool._view.show(smaller))
        browser.say("score")
        assert "region" in browser.take("note", level="error")[0]["text"]


def test_what_is_wrong_is_refused_by_its_name(here):
    threads = threading.active_count()
    for arguments, said in (
        ({"what": 3}, "`what` must"),
        ({"what": "none.png"}, "none.png"),
        ({"colors": 3}, "colors must"),
        ({"robot": "nobody"}, "nobody"),
    ):
        with pytest.raises((TypeError, ValueError, OSError), match=said):
            robsim.gui.color_panel(**arguments)
    assert threading.active_count() == threads


IMAGE = (
    np.repeat([RED, (230, 120, 30), FLOOR], 10, axis=0)[None].repeat(40, axis=0).astype(np.uint8)
)
STRIPES = [(10 * n, 0, 10 * n + 9, 39) for n in range(3)]


def test_more_regions_add_up_and_show_their_drift():
    training = ColorTraining()
    training.train("red", IMAGE, STRIPES[0], picture="frame 0")
    before = training.value[0]
    training.adjust("red", margin=0, percentile=0)
    training.train("red", IMAGE, STRIPES[1], picture="frame 9", keep=1)
    both = sum(color_histograms(IMAGE, stripe) for stripe in STRIPES[:2])
    expected = ColorClass.from_histograms(both, name="red", percentile=0, margin=0)
    assert training.value == (expected,)
    assert training.value != (before,)
    (first, red, share_of_first), (second, orange, share_of_second) = training.drift("red")
    assert (first, second) == ("frame 0", "frame 9")
    assert share_of_first == share_of_second == 1
    assert orange[0] > red[0] + 30  # brighter
    training.put(ColorClass("red", y=(0, 100)))
    assert [share for _, _, share in training.drift("red")] == [1, 0]


def test_too_many_are_refused():
    training = ColorTraining(ColorClass(f"c{n}") for n in range(32))
    with pytest.raises(ValueError, match="at most 32 colours"):
        training.put(ColorClass("another"))
    with pytest.raises(ValueError, match="at most 32 colours"):
        training.train("another", IMAGE, STRIPES[0])
    before = training.value
    with pytest.raises(ValueError, match="at most 32 colours, got 33"):
        training.replace(ColorClass(f"d{n}") for n in range(33))
    assert training.value == before
    with pytest.raises(ValueError, match="grey"):
        training.train("c0", IMAGE, STRIPES[2])
    assert training.value == before
    for _ in range(100):
        training.train("c0", IMAGE, STRIPES[0], keep=100)
    with pytest.raises(ValueError, match="at most 100 regions"):
        training.train("c0", IMAGE, STRIPES[0], keep=100)


def test_ranges_by_hand_and_a_whole_file():
    training = ColorTraining([ColorClass("red"), ColorClass("blue")])
    training.train("red", IMAGE, STRIPES[0])
    training.put(ColorClass("red", v=(150, 250)))
    training.put(ColorClass("green"))
    assert [color.name for color in training.value] == ["red", "blue", "green"]
    assert training.value[0].v == (150, 250)
    training.replace([ColorClass("green"), ColorClass("red", u=(1, 2))])
    assert [color.name for color in training.value] == ["green", "red"]
    assert len(training.drift("red")) == 1  # what it was made from is still known
    training.remove("green")
    assert training.value == (ColorClass("red", u=(1, 2)),)


def test_a_picture_for_which_memory_is_lacking_is_refused(view, monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr("robsim.gui.tools.tool.over_floor", fail)
    before = view.picture
    with pytest.raises(ValueError, match="not enough memory"):
        view.load_picture(np.zeros((8, 8, 4), np.uint8))
    assert view.picture is before


def test_the_mouse_s_undo_and_redo_are_methods(tmp_path):
    with robsim.gui.color_panel(picture(), robot="lab", file=tmp_path / "colors.toml") as tool:
        red = tool.train("red", (20, 20, 29, 29))
        tool.undo()
        assert tool.value == ()
        tool.redo()
        assert tool.value == (red,)
