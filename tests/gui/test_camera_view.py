"""The camera's picture in a browser: overlays, zoom, and what the mouse, fingers and keys say."""

import math

import numpy as np
import pytest

from robsim.vision import Intrinsics, PlaneMap
from waiting import wait_for

pytestmark = pytest.mark.slow

GREEN, MAGENTA, BLUE = (18, 161, 80), (214, 33, 156), (59, 130, 246)
AREA = {"area": [600, 600]}
DRIVEN = {"controls": [], "values": {"control": "go-to-point"}}


@pytest.fixture
def camera(open_fake):
    """Return a function that shows a camera view of 600 x 600 px; the host and the canvas's box."""

    def show(*, state=None, setup=None, frame=None, **options):
        host = open_fake(**{"size": (1600, 1000), **options})
        host.tab.add_style_tag(
            content=".robsim-view { width: 600px !important; height: 600px !important; "
            "flex: none !important; border: 0 !important; aspect-ratio: auto !important; }"
        )
        host.setup(**(AREA | (setup or {})))
        host.state(**(state or {}))
        host.frame(0, **(frame or {}))
        host.paint()
        box = host.tab.locator(".robsim-camera canvas").bounding_box()
        assert (box["width"], box["height"]) == (600, 600)
        return host, lambda x, y: (box["x"] + x + 0.5, box["y"] + y + 0.5)

    return show


def has_near(host, point, color, *, reach=3, tolerance=60):
    """Whether a colour was painted near a point of the picture on the screen."""
    x, y = (round(value) for value in point)
    read = (
        "([x, y, n]) => { const c = document.querySelector('.robsim-camera canvas');"
        " return [...c.getContext('2d').getImageData(x, y, n, n).data] }"
    )
    side = 2 * reach + 1
    pixels = np.reshape(host.tab.evaluate(read, [x - reach, y - reach, side]), (-1, 4))[:, :3]
    return bool((np.abs(pixels - color).max(axis=1) < tolerance).any())


def test_the_picture_fills_its_box_in_device_pixels_and_another_size_is_told(camera):
    image = np.full((1200, 1200, 3), 190, np.uint8)
    host, _ = camera(device_scale_factor=2, frame={"image": image})
    size = "(c => [c.width, c.height])(document.querySelector('.robsim-camera canvas'))"
    assert host.tab.evaluate(size) == [1200, 1200]
    assert host.sent("hello")[0]["width"] > 0
    host.tab.add_style_tag(content=".robsim-view { width: 400px !important; }")
    wait_for(lambda: [message["width"] for message in host.sent("size")][-1:] == [800])


def test_a_camera_that_is_not_square_is_letterboxed(camera):
    host, at = camera(frame={"image": np.full((300, 600, 3), 190, np.uint8)}, state=DRIVEN)
    host.tab.mouse.click(*at(300, 50))  # above the picture
    assert host.sent("go_to") == []
    host.tab.mouse.click(*at(300, 149.5 + 20))
    assert host.sent("go_to")[0] == pytest.approx({"type": "go_to", "x": 300, "y": 20}, abs=1)


def test_overlays_are_drawn_where_the_robot_is_and_can_be_switched(camera):
    pose, front = [200.0, 300.0, math.pi / 2], (200, 340)
    frame = {"measured": pose, "truth": [400.0, 300.0, 0.0], "boxes": [["blue", 90, 90, 110, 110]]}
    host, _ = camera(frame=frame)
    assert has_near(host, front, GREEN)
    assert has_near(host, (90, 100), BLUE)
    assert not has_near(host, (440, 300), MAGENTA)  # truth is off at first
    host.tab.click("button[name=show]")
    host.tab.check("input[name=show_truth]")
    for name in ("outline", "heading_line", "boxes"):
        host.tab.uncheck(f"input[name=show_{name}]")
    host.paint()
    assert has_near(host, (440, 290), MAGENTA)
    assert not has_near(host, front, GREEN)
    assert not has_near(host, (90, 100), BLUE)


def test_overlays_are_drawn_and_clicked_through_the_lens(camera):
    # A pincushion that moves the corners out by 20 px, of a camera that is tilted, too.
    tilted = [1, 0, 0, 0, 1, 0, 0, -1 / 1200, 1]
    distortion = (0.13, 0.02, 0.004, -0.003, 0.001)
    lens = Intrinsics([[600, 0, 299.5], [0, 580, 305], [0, 0, 1]], distortion)
    plane_map = PlaneMap(np.reshape(tilted, (3, 3)), lens)
    x, y = plane_map.to_world((60, 90))
    frame = {"map": tilted, "intrinsics": [600, 580, 299.5, 305, *distortion]}
    host, at = camera(
        frame=frame | {"measured": [x, y, 0.0]}, setup={"area": [1200, 1200]}, state=DRIVEN
    )
    corner = plane_map.to_pixel((x + 40, y - 25))
    plain = PlaneMap(plane_map.matrix).to_pixel((x + 40, y - 25))
    assert np.hypot(*(corner - plain)) > 8
    assert has_near(host, corner, GREEN)
    assert not has_near(host, plain, GREEN)
    for pixel in ((60, 90), (550, 40), (580, 590), (300, 300)):
        host.forget()
        host.tab.mouse.click(*at(*pixel))
        x, y = plane_map.to_world(pixel)
        assert host.sent("go_to")[0] == pytest.approx({"type": "go_to", "x": x, "y": y}, abs=1.5)


def test_no_place_is_clicked_where_the_lens_shows_nothing(camera):
    frame = {"intrinsics": [300, 300, 299.5, 299.5, -0.3, 0, 0, 0, 0]}  # up to 210 px
    host, at = camera(frame=frame, state=DRIVEN)
    host.tab.mouse.click(*at(20, 20))
    assert host.sent("go_to") == []
    host.tab.mouse.click(*at(300, 400))
    assert len(host.sent("go_to")) == 1


def test_the_path_driven_is_drawn_up_to_the_step(camera):
    host, _ = camera(state={"k": 40, "steps": 41})
    driven = np.stack([np.linspace(100, 500, 41), np.full(41, 450.0), np.zeros(41)], axis=1)
    driven[20:23] = np.nan
    host.frame(40, rows={"pose_measured": driven})
    assert has_near(host, (150, 450), GREEN)
    assert has_near(host, (400, 450), GREEN)
    assert not has_near(host, (310, 450), GREEN)  # not seen there
    host.tab.keyboard.press("ArrowLeft")
    host.frame(10, past=True)
    assert has_near(host, (150, 450), GREEN)
    assert not has_near(host, (400, 450), GREEN)


def test_a_drawn_path_is_simplified(camera):
    host, at = camera()
    host.tab.click("button[name=draw_path]")
    host.tab.mouse.move(*at(100, 100))
    host.tab.mouse.down()
    host.tab.mouse.move(*at(400, 100), steps=10)
    host.tab.mouse.move(*at(400, 400), steps=10)
    host.tab.mouse.up()
    (path,) = host.sent("path")
    expected = [(100, 100), (400, 100), (400, 400)]
    np.testing.assert_allclose(path["points"], expected, atol=3)


def test_corners_of_a_path_are_clicked(camera):
    host, at = camera()
    corners = [(100, 100), (300, 120), (500, 500)]
    for end in (
        lambda: host.tab.keyboard.press("Enter"),
        lambda: host.tab.mouse.dblclick(*at(500, 500)),
    ):
        host.forget()
        host.tab.click("button[name=draw_path]")
        for point in corners:
            host.tab.mouse.click(*at(*point))
        end()
        (path,) = host.sent("path")
        np.testing.assert_allclose(path["points"], corners, atol=1)
    host.forget()
    host.tab.click("button[name=draw_path]")
    for point in corners[:2]:
        host.tab.mouse.click(*at(*point))
    host.tab.keyboard.press("Escape")  # gives it up
    host.tab.keyboard.press("Enter")
    assert host.sent("path") == []


def test_the_wheel_zooms_around_the_pointer_and_a_double_click_shows_all(camera):
    host, at = camera(frame={"measured": [200.0, 300.0, 0.0]}, state=DRIVEN)
    host.tab.mouse.move(*at(400, 200))
    host.tab.mouse.wheel(0, -600)
    host.paint()
    zoom = float(host.tab.inner_text("button[name=zoom_reset]").rstrip("\u00d7"))
    assert zoom > 2
    host.tab.mouse.click(*at(400, 200))
    host.tab.mouse.click(*at(400 + 50, 200))
    here, beside = host.sent("go_to")
    assert here == pytest.approx({"type": "go_to", "x": 400, "y": 200}, abs=1)
    assert beside["x"] - here["x"] == pytest.approx(50 / zoom, abs=1)
    host.tab.mouse.move(*at(400, 200))
    host.tab.mouse.down()
    host.tab.mouse.move(*at(300, 200), steps=5)
    host.tab.mouse.up()
    host.tab.mouse.dblclick(*at(300, 200))  # where that was dragged to
    host.paint()
    assert host.sent("go_to")[2]["x"] == pytest.approx(here["x"], abs=2)
    assert not host.tab.is_visible("button[name=zoom_reset]")
    assert has_near(host, (200, 325), GREEN)


def test_keys_move_a_cross_and_set_it(camera):
    host, _ = camera()
    host.tab.click("button[name=go_to]")
    for key in ["ArrowRight", "ArrowRight", "ArrowUp", "Shift+ArrowLeft"]:
        host.tab.keyboard.press(key)
    host.paint()
    assert "210.0" in host.tab.inner_text(".robsim-camera-readout")
    host.tab.keyboard.press("Enter")
    assert host.sent("go_to") == [{"type": "go_to", "x": 210, "y": 290}]


def test_a_finger_taps_a_goal_and_two_zoom(camera):
    host, at = camera(state=DRIVEN, has_touch=True)
    host.tab.touchscreen.tap(*at(150, 250))
    assert host.sent("go_to")[0] == pytest.approx({"type": "go_to", "x": 150, "y": 250}, abs=1)
    talk = host.tab.context.new_cdp_session(host.tab)

    def touch(kind, *points):
        touches = [{"x": at(*p)[0], "y": at(*p)[1], "id": i} for i, p in enumerate(points)]
        talk.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

    touch("touchStart", (250, 300), (350, 300))
    for spread in range(60, 160, 10):
        touch("touchMove", (300 - spread, 300), (300 + spread, 300))
    touch("touchEnd")
    host.paint()
    zoom = float(host.tab.inner_text("button[name=zoom_reset]").rstrip("\u00d7"))
    assert zoom == pytest.approx(3, abs=0.3)


def test_the_pointer_over_the_robot_reads_its_poses(camera):
    estimate = {"pose": [201.0, 299.0, 0.0], "covariance": [4, 0, 0, 0, 9, 0, 0, 0, 0.0001]}
    frame = {"measured": [200.0, 300.0, -0.5], "truth": [200.5, 300.5, -0.5], "estimate": estimate}
    host, at = camera(frame=frame)
    host.tab.mouse.move(*at(205, 305))
    host.paint()
    said = host.tab.inner_text(".robsim-camera-readout")
    for part in ("x 205.0", "\u221228.6\u00b0", "201.0 \u00b1 2.0"):
        assert part in said
    host.tab.mouse.move(*at(500, 500))
    host.paint()
    assert "201.0" not in host.tab.inner_text(".robsim-camera-readout")


def test_it_says_why_the_robot_was_not_seen(camera):
    missed = {"missed": "no blue blob", "held": [200.0, 300.0, 0.0]}
    host, _ = camera(frame=missed)
    assert "no blue blob" in host.tab.inner_text(".robsim-camera-badges")
    assert has_near(host, (240, 300), (0, 0, 0))


GOAL = (14, 143, 158)  # of a light theme


def test_a_goal_is_a_ring_and_its_heading_an_arrow(camera):
    """The arrow is as long as the line of the heading of the robot, which reaches 40 px ahead."""
    host, _ = camera(state={"goal": [300, 200, math.pi / 2], "path": None})
    reach = 1.35 * 40
    assert has_near(host, (300 + 8, 200), GOAL)  # the ring
    assert has_near(host, (300, 200 + reach - 2), GOAL)  # down, along the heading
    assert not has_near(host, (300, 200 - reach + 2), GOAL)
