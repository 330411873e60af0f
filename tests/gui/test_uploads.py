"""Pictures from browsers into a tool: parts, limits, what is refused, what is left behind."""

import io
import json
import threading
import zlib
from contextlib import ExitStack

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import robsim
from browsers import FakeBrowser, Page, settled
from fuzzing import fuzzed
from page_client import BINARY, greeted
from python_devices import PATIENT, SteppedCamera
from robsim.gui.hosts.serving import packed_message, unpacked_message
from robsim.vision import load_robot
from robsim.vision.imaging import images
from waiting import wait_for

FLOOR = np.full((30, 40, 3), (120, 122, 118), np.uint8)
OTHER = np.random.default_rng(5).integers(0, 255, (24, 36, 3)).astype(np.uint8)
UPLOADS = "robsim.gui.tools.uploads"


def png(pixels, **options):
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "PNG", **options)
    return out.getvalue()


@pytest.fixture
def view(tmp_path):
    with robsim.gui.color_panel(FLOOR, robot="lab", file=tmp_path / "colors.toml") as tool:
        yield tool._view
    assert list(tmp_path.iterdir()) == []  # no file was written
    assert not [one for one in threading.enumerate() if one.name == "robsim upload"]


@pytest.fixture
def browser(view):
    browser = FakeBrowser(view, 40)
    browser.take("frame")
    return browser


def shown(view):
    return view.picture.frame.image


def waiting(view):
    settled(view)
    return [*view._uploads._coming.values(), *view._uploads._complete]


def test_a_picture_comes_in_parts_and_is_shown(view, browser):
    content = png(OTHER)
    assert len(content) > 2000
    answer = browser.upload(content, part=1000)
    assert (answer["state"], answer["at"], answer["text"]) == ("taken", len(content), "")
    np.testing.assert_array_equal(shown(view), OTHER)
    browser.take("frame", name="photo.png")
    assert view._setup()["back"] == "picture"
    browser.say("back")
    browser.take("frame", name="a picture")
    np.testing.assert_array_equal(shown(view), FLOOR)
    assert view._setup()["back"] is None
    browser.say("back")
    assert "nothing to return to" in browser.take("note", level="error")[0]["text"]
    assert waiting(view) == []


@pytest.mark.filterwarnings("ignore:pictures that viewers rotate")
def test_a_picture_lies_as_on_the_sensor_and_on_a_grey_floor(view, browser):
    turned = Image.Exif()
    turned[0x0112] = 6  # to be turned clockwise
    browser.upload(png(OTHER, exif=turned))
    np.testing.assert_array_equal(shown(view), OTHER)
    browser.upload(png(np.dstack([OTHER, np.zeros(OTHER.shape[:2], np.uint8)])))
    assert (shown(view) == 150).all()


def first_part(content=b"x" * 300, **fields):
    return {"key": "1", "name": "p.png", "size": len(content), "at": 0} | fields


def test_what_is_wrong_is_said_and_leaves_nothing(view):
    for parts, said in (
        ([(b"x", {"at": 7})], "no longer known"),
        ([(b"x" * 100, {}), (b"x", {"at": 99})], "at byte 100, got byte 99"),
        ([(b"x" * 301, {})], "differs from the announced 300 bytes"),
        ([(b"x" * 100, {}), (b"", {"at": 100})], "differs from the announced"),
        ([(b"x" * 100, {}), (b"x", {"at": 100, "size": 900})], "changed during the upload"),
        ([(b"", {"size": 0})], "p.png is empty"),
        ([(b"x", {"size": 65 * 10**6 + 2_108_864})], "at most 64 MB"),
        ([(b"x" * 300, {})], "p.png is not in an image format"),
        ([(png(OTHER)[:300], {})], "p.png cannot be read"),
    ):
        browser = FakeBrowser(view, 40)
        for part, fields in parts:
            browser.say("upload", part, **first_part(**fields))
        assert said in browser.take("uploaded", state="refused")[0]["text"]
        np.testing.assert_array_equal(shown(view), FLOOR)
        assert waiting(view) == []
    assert browser.upload(png(OTHER), key="next")["state"] == "taken"


def test_buffers_are_one_and_not_large(view, browser):
    for buffers in ([], [b"x", b"y"], [b"x" * (524_288 + 1)], [b"x" * (1 << 22), b"y"]):
        browser.say("upload", *buffers, **first_part())
        assert "up to 524288 bytes" in browser.take("note", level="error")[0]["text"]


def test_what_a_message_says_of_its_buffers_counts_for_nothing(view, browser):
    browser.say("upload", **first_part(buffers=[[1, 2]]))
    assert "buffers of the message" in browser.take("note", level="error")[0]["text"]
    browser.say("freeze", b"thrown away", on=True)
    browser.take("state", frozen=True)
    assert browser.bytes_waiting == 0


def test_a_picture_with_too_many_pixels_is_refused(view, browser):
    content = png(np.zeros((1, 1, 3), np.uint8))
    header = b"IHDR" + b"".join(n.to_bytes(4, "big") for n in (20_000, 20_000)) + content[24:29]
    checksum = zlib.crc32(header).to_bytes(4, "big")
    answer = browser.upload(content[:12] + header + checksum + content[33:])
    assert "too many pixels" in answer["text"]
    np.testing.assert_array_equal(shown(view), FLOOR)


def test_two_browsers_do_not_mix(view, browser):
    other = FakeBrowser(view, 40)
    contents = {browser: png(OTHER), other: png(OTHER[::-1])}
    half = {one: len(content) // 2 for one, content in contents.items()}
    for one, content in contents.items():
        one.say("upload", content[: half[one]], **first_part(content))
    for one, content in contents.items():
        one.say("upload", content[half[one] :], **first_part(content, at=half[one]))
    for one in contents:
        one.take("uploaded", state="taken")
    np.testing.assert_array_equal(shown(view), OTHER[::-1])
    assert waiting(view) == []


def test_what_is_given_up_or_left_is_forgotten(view, browser):
    other = FakeBrowser(view, 40, name="other")
    for end in (
        lambda: browser.say("give_up", key="1"),
        lambda: browser.say("bye"),
        lambda: view.disconnect(browser),
    ):
        other.say("upload", b"x", **first_part())
        browser.say("upload", b"x", **first_part())
        assert len(waiting(view)) == 2
        end()
        assert [one.link for one in waiting(view)] == [other]
        other.say("give_up", key="1")


def test_what_stalls_is_forgotten(view, browser, monkeypatch):
    monkeypatch.setattr(f"{UPLOADS}.PATIENCE", 0.01)
    browser.say("upload", b"x", **first_part())
    browser.take("uploaded", state="more")
    wait_for(lambda: not view._uploads._coming)
    browser.say("upload", b"x", **first_part(at=1))
    assert "load the file" in browser.take("uploaded", state="refused")[0]["text"]


def test_only_so_many_come_at_the_same_time(view, browser):
    for key in "1234":
        browser.say("upload", b"x", **first_part(key=key))
    browser.say("upload", b"x", **first_part(key="5"))
    assert "too many uploads" in browser.take("uploaded", state="refused")[0]["text"]
    assert len(waiting(view)) == 4


def test_what_is_given_up_while_it_is_decoded_is_not_shown(view, browser, monkeypatch):
    decoding, go_on = threading.Event(), threading.Event()
    decoded = images.decoded

    def slow(*arguments):
        decoding.set()
        assert go_on.wait(300)
        return decoded(*arguments)

    monkeypatch.setattr(images, "decoded", slow)
    content = png(OTHER)
    browser.say("upload", content, **first_part(content))
    assert decoding.wait(300)
    browser.say("freeze", on=True)
    browser.take("state", frozen=True)  # the view goes on meanwhile
    browser.say("give_up", key="1")
    settled(view)
    go_on.set()
    wait_for(lambda: not waiting(view))
    np.testing.assert_array_equal(shown(view), FLOOR)


@pytest.mark.long
def test_a_live_picture_waits_and_comes_back(tmp_path):
    source = SteppedCamera([FLOOR + k for k in range(9)])
    source.permits.release()  # the size is that of a frame
    with ExitStack() as stack:
        camera = stack.enter_context(robsim.Camera(source, **PATIENT))
        view = stack.enter_context(robsim.gui.color_panel(camera, file=tmp_path / "c.toml"))._view
        browser = FakeBrowser(view, 40)
        source.permits.release()
        browser.take("frame")
        view._region = (0, 0, 9, 9)
        browser.upload(png(OTHER))
        assert view._setup()["back"] == "live"
        assert view._state()["region"] is None
        before = view._taken
        source.permits.release()
        wait_for(lambda: view._taken is not before)  # it is read on
        settled(view)
        np.testing.assert_array_equal(shown(view), OTHER)
        browser.say("back")
        browser.take("setup", is_live=True, back=None)
        wait_for(lambda: view.picture is view._taken)
        source.permits.release()
        wait_for(lambda: (shown(view) == FLOOR + 3).all())


LARGEST = 200  # px along a side


@pytest.fixture
def robots(user_folder, monkeypatch):
    monkeypatch.setattr("robsim.vision.robots.sketch.MAXIMUM_SIDE", LARGEST)
    with robsim.gui.robot_panel(robot="lab") as tool:
        yield tool._view


@pytest.mark.long
def test_a_robot_that_is_cut_out_is_drawn_on_at_once(robots):
    lab = load_robot("lab")
    large = np.kron(lab.image, np.ones((2, 2, 1), np.uint8))
    assert max(large.shape) > LARGEST
    browser = FakeBrowser(robots, 200)
    assert browser.upload(png(large))["state"] == "taken"
    state = robots._state()
    assert (state["mode"], state["problems"]) == ("draw", [])
    assert not state["can_capture"]
    scale = robots.drawing.sketch.image.shape[1] / lab.image.shape[1]
    assert max(robots.drawing.sketch.image.shape) == LARGEST
    drawn = robots.drawing.sketch.definition("seen")
    assert drawn.size == lab.size
    assert drawn.radius == pytest.approx(lab.radius, rel=0.1)
    (red,) = (one.polygon for one in drawn.markers.values() if one.color == "red")
    middle = lab.markers["right"].polygon.mean(axis=0)
    np.testing.assert_allclose(red.mean(axis=0) / scale, middle, atol=3)


@pytest.mark.long
def test_a_photograph_is_captured_in_part_or_whole(robots):
    sim = robsim.Simulation(robot="lab", start=(200, 200, 0.6), area=(400, 400), seed=2)
    photo = sim.step().frame.image
    height, width = photo.shape[:2]
    browser = FakeBrowser(robots, 200)
    browser.upload(png(photo))
    state = robots._state()
    assert state["mode"] == "capture"
    assert state["square"] == [width / 2, height / 2, 0.4 * min(width, height)]
    browser.say("no_camera")
    settled(robots)
    assert robots._state()["mode"] == "draw"
    browser.say("resume")
    browser.say("capture")
    settled(robots)
    assert robots._state()["problems"] == []
    assert robots.drawing.sketch.image.shape[1] == round(0.4 * min(width, height))
    browser.say("resume")
    browser.say("capture_whole")
    settled(robots)
    assert max(robots.drawing.sketch.image.shape) == LARGEST


def test_a_transparent_picture_is_no_robot(robots):
    browser = FakeBrowser(robots, 200)
    browser.take("frame")
    before = robots.drawing.sketch
    answer = browser.upload(png(np.zeros((20, 20, 4), np.uint8)))
    assert "transparent everywhere" in answer["text"]
    assert robots.drawing.sketch is before


@pytest.mark.long
def test_methods_do_what_the_mouse_does(tmp_path, user_folder):
    file = tmp_path / "other.png"
    file.write_bytes(png(OTHER))
    with robsim.gui.color_panel(FLOOR, file=tmp_path / "c.toml") as tool:
        tool.load(file)
        np.testing.assert_array_equal(shown(tool._view), OTHER)
        assert tool._view.picture.name == "other.png"
        tool.load(robsim.Frame(FLOOR))
        tool.go_back()
        assert tool._view.picture.name == "a picture"
        file.write_bytes(b"nothing")
        with pytest.raises(ValueError, match=r"other\.png"):
            tool.load(file)
    with robsim.gui.robot_panel(FLOOR, robot="sheep") as tool:
        tool.load(OTHER)
        tool.capture(whole=True)
        np.testing.assert_array_equal(tool._view.drawing.sketch.image[..., :3], OTHER)
        tool.go_back()
        np.testing.assert_array_equal(shown(tool._view), FLOOR)


def test_what_is_packed_is_unpacked():
    head, buffers = {"type": "upload", "name": "\u00e4.png"}, [b"abc", b"", b"12345678"]
    unpacked, parts = unpacked_message(packed_message(head, buffers))
    assert unpacked == {**head, "buffers": [3, 0, 8]}
    assert parts == buffers
    assert unpacked_message('{"type": "bye"}') == ({"type": "bye"}, ())


def test_garbage_says_nothing():
    bye = packed_message({"type": "bye"}, [b"abcd"])
    for packed in (
        *(b"", b"\0\0", b"\xff\xff\xff\xff{}", b"\2\0\0\0{}", b"\4\0\0\0[[]]", "{"),
        *(b"\1\0\0\0\xff", bye[:-1], bye + b"more", bye.replace(b"[4]", b"[9]")),
        packed_message({"type": "bye"}, [b"abcdefgh"]).replace(b"[8]", b"-8 "),
        b"\x14\0\0\0" + b'{"buffers":[true]}  ' + b"abcd",
    ):
        assert unpacked_message(packed) == (None, ())


def test_a_page_sends_its_buffers_and_leaves_nothing(view):
    page = Page(view)
    content = png(OTHER)
    head = {"type": "upload", "id": "me", **first_part(content)}
    try:
        with greeted(page) as client:
            client.send(packed_message(head, [content[:99]]), BINARY)
            assert client.hear("uploaded")[0]["at"] == 99
            client.send(packed_message(head | {"at": 99}, [content[99:]])[:-1], BINARY)
            assert "not a message" in client.hear("note")[0]["text"]
            client.send(packed_message(head | {"at": 99}, [content[99:]]), BINARY)
            assert [client.hear("uploaded")[0]["state"] for _ in "ab"] == ["read", "taken"]
            np.testing.assert_array_equal(shown(view), OTHER)
            client.send(packed_message(head, [content[:99]]), BINARY)
            client.hear("uploaded")
            assert len(waiting(view)) == 1
        wait_for(lambda: not waiting(view))
    finally:
        page.close()


@fuzzed
@given(st.binary(max_size=60), st.lists(st.integers(-9, 9) | st.none() | st.booleans(), max_size=4))
def test_any_bytes_are_a_message_or_none(rest, lengths):
    head = json.dumps({"type": "upload", "buffers": lengths}).encode()
    for packed in (rest, len(head).to_bytes(4, "little") + head + rest):
        message, buffers = unpacked_message(packed)
        assert [len(one) for one in buffers] == (message["buffers"] if message else [])
