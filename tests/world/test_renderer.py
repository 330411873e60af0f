"""Renderers and the scenes that they share."""

from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim._core import Renderer, Scene
from robsim.simulation import draw_red_square
from robsim.simulation.world.scene import SceneCache
from scenes import renderer, small_renderer
from threads import together

# --- renderers


CENTRE = (600.0, 600.0, 0.0)


def drawn_by_hand(floor, sprite, centre, pose):
    """What the renderer has to draw in an area of a pixel a px, pixel by pixel."""
    height, width = sprite.shape[:2]
    alpha = np.zeros((height + 2, width + 2))
    alpha[1:-1, 1:-1] = sprite[..., 3] / 255
    colors = np.zeros((height + 2, width + 2, 3))
    colors[1:-1, 1:-1] = sprite[..., :3] * alpha[1:-1, 1:-1, None]
    result = floor.astype(float)
    for v, u in np.ndindex(floor.shape[:2]):
        dx, dy = u - pose[0], v - pose[1]
        su = centre[0] + 1 + dx * np.cos(pose[2]) + dy * np.sin(pose[2])
        sv = centre[1] + 1 - dx * np.sin(pose[2]) + dy * np.cos(pose[2])
        left, top = int(np.floor(su)), int(np.floor(sv))
        if not (0 <= left <= width and 0 <= top <= height):
            continue
        across, down = (1 - (su - left), su - left), (1 - (sv - top), sv - top)
        weights = np.outer(down, across)
        square = np.s_[top : top + 2, left : left + 2]
        opacity = (weights * alpha[square]).sum()
        color = (weights[..., None] * colors[square]).sum(axis=(0, 1))
        result[v, u] = result[v, u] * (1 - opacity) + color
    return result


@pytest.mark.long
@pytest.mark.parametrize("size", [(7, 4), (1, 9), (90, 80)])
def test_every_pixel_is_what_it_is_by_hand(size, rng):
    sprite = rng.integers(0, 256, (*size[::-1], 4), dtype=np.uint8)
    sprite[..., 3] = rng.choice([0, 100, 255], size[::-1])
    floor = rng.integers(0, 256, (40, 110, 3), dtype=np.uint8)
    centre = (size[0] * 0.4, size[1] * 0.6)
    scene = Scene(
        floor=(floor, floor),
        home=(floor, floor),
        shadow_left=110,
        shadow_factor=0.8,
        sprite=sprite,
        centre=centre,
        unit=1,
        alignment=0,
        headings=0,
        area=(110, 40),
    )
    draw = Renderer(scene)
    for heading in (0, np.pi / 2, *rng.uniform(-np.pi, np.pi, 3)):
        pose = (*rng.uniform((0, 0), (109, 39)), heading)
        expected = drawn_by_hand(floor, sprite, centre, pose)
        assert np.abs(draw.render(pose) - expected).max() <= 0.51


def test_an_image_that_is_held_is_never_overwritten():
    draw = renderer(resolution=(240, 240))
    held, copies = [], []
    for k in range(6):
        held.append(draw.render((300.0 + 20 * k, 400.0, 0.1 * k)))
        copies.append(held[-1].copy())
    for image, copy in zip(held, copies, strict=True):
        np.testing.assert_array_equal(image, copy)
        with pytest.raises(ValueError, match="read-only"):
            image[0, 0, 0] = 0


def test_one_asymmetric_frame_pins_down_axes_and_directions():
    # At heading 0 the robot faces right, its red marker lies to its right: below the blue one.
    blobs = robsim.find_blobs(renderer().render((300.0, 800.0, 0.0)), robsim.load_colors())
    red = next(blob for blob in blobs["red"] if blob.area < 1000)
    np.testing.assert_allclose(red.centroid, (300 - 14, 800 + 21.5), atol=0.15)
    np.testing.assert_allclose(blobs["blue"][0].centroid, (300 - 14, 800 - 21.5), atol=0.15)
    # A quarter turn to the right (clockwise): it faces down, red lies to the left of blue.
    blobs = robsim.find_blobs(renderer().render((300.0, 800.0, np.pi / 2)), robsim.load_colors())
    red = next(blob for blob in blobs["red"] if blob.area < 1000)
    np.testing.assert_allclose(red.centroid, (300 - 21.5, 800 - 14), atol=0.15)
    np.testing.assert_allclose(blobs["blue"][0].centroid, (300 + 21.5, 800 - 14), atol=0.15)


def test_phases_show_the_nearest_heading_at_the_nearest_pixel():
    draw = renderer(headings=36)
    shown = draw.render((600.0, 600.0, np.deg2rad(40)))
    for pose in [(600.4, 599.6, np.deg2rad(44.9)), (599.6, 600.4, np.deg2rad(35.1 - 360))]:
        np.testing.assert_array_equal(draw.render(pose), shown)
    for pose in [(600.6, 600.0, np.deg2rad(40)), (600.0, 600.0, np.deg2rad(45.1))]:
        assert (draw.render(pose) != shown).any()


def test_the_shadow_falls_on_the_robot_too():
    plain = np.full((1200, 1200, 3), 200, np.uint8)
    draw = renderer(background=plain, adjust_background=lambda background: background)
    lit, dark = (draw.render((x, 600.0, 0.7)).astype(float) for x in (400.0, 1000.0))
    np.testing.assert_array_equal(lit[0, 0], 200)
    np.testing.assert_array_equal(dark[0, 1199], 160)
    robot = lit[540:660, 340:460], dark[540:660, 940:1060]
    assert np.abs(robot[1] - 0.8 * robot[0]).max() <= 1.0


def test_far_away_robots_are_not_drawn():
    draw = renderer(adjust_background=lambda background: background)
    empty = draw.render((-5000.0, 1e12, 0.0)).copy()
    np.testing.assert_array_equal(draw.render((1e300, -1e300, 1.0)), empty)
    assert (draw.render(CENTRE) != empty).any()


@pytest.mark.long
def test_any_finite_pose_and_view_can_be_drawn(rng):
    extremes = [0.0, -0.0, 5e-324, 1e308, -1e308, 1e9, *rng.uniform(-1e3, 1e3, 20)]
    ends = [0, 7, -1, -(2**31), 2**31 - 1]
    floor = np.full((8, 10, 3), 100, np.uint8)
    for headings in (0, 4):
        draw = small_renderer(headings=headings)
        for _ in range(200):
            pose, pan = rng.choice(extremes, 3), rng.choice(ends, 2)
            image = draw.render(pose, tuple(pan.tolist()))
            assert image.shape == floor.shape
            if abs(pose[0]) > 100 and not pan.any():
                np.testing.assert_array_equal(image, floor)


def test_what_cannot_be_drawn():
    image = np.full((8, 10, 3), 100, np.uint8)
    for name, values in {
        "floor": ((image,), (image[:4], image), (image.astype(float), image)),
        "home": ((image, image[:, ::-1]),),
        "shadow_factor": (-0.01, 1e308),
        "sprite": (np.zeros((4, 4, 3), np.uint8), np.zeros((0, 4, 4), np.uint8)),
        "centre": ((np.inf, 1), (1e9, 0), (1, 2, 3)),
        "unit": (0, -1, 1e9),
        "alignment": (np.nan,),
        "headings": (-1, 2**31),
        "area": ((0, 1), (1, -1), (2**31, 1)),
    }.items():
        for value in values:
            with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                small_renderer(**{name: value})
    for pan in ((1.5, 1), (2**31, 0), (0, -(2**31) - 1)):
        with pytest.raises((TypeError, ValueError), match=r"\bpan\b"):
            small_renderer().render((5, 4, 0), pan)


def test_the_moved_view_shows_the_floor_again_but_the_square_once():
    draw = renderer()
    away = (5000.0, 5000.0, 0.0)
    home = draw.render(away).copy()
    right = draw.render(away, pan=(1200, 0)).copy()
    red = robsim.ColorClass("red", v=(164, 255))
    assert robsim.find_blobs(home, [red])["red"]
    assert not robsim.find_blobs(right, [red])["red"]
    differs = (home != right).any(axis=2)
    assert differs.sum() == robsim.find_blobs(home, [red])["red"][0].area
    # Moved by less than a view: the same world, at other pixels; the shadow stays with the view.
    moved = draw.render(away, pan=(100, -30))
    np.testing.assert_array_equal(moved[30:, :700], home[:-30, 100:800])
    np.testing.assert_array_equal(moved[30:, 800:1100], home[:-30, 900:1200])
    lit, dark = home[:-30, 750:800].astype(float), moved[30:, 650:700].astype(float)
    np.testing.assert_array_equal(lit, dark)


# --- shared scenes


def test_renderers_of_one_scene_in_threads():
    whole = small_renderer(headings=36).scene
    expected = [small_renderer(headings=36).render((5, 4, h)).copy() for h in range(7)]

    def draw():
        own, out = Renderer(whole), np.zeros((8, 10, 3), np.uint8)
        for k in range(200):
            own.render((5, 4, k % 7), out=out)
            np.testing.assert_array_equal(out, expected[k % 7])

    together(draw, draw, draw, draw)


def test_a_scene_of_the_same_is_the_same_and_of_something_else_another():
    lab = robsim.load_robot("lab")
    floor = np.random.default_rng(1).integers(0, 256, (300, 400, 3), dtype=np.uint8)
    size = {"area": (400, 300), "resolution": (200, 150)}

    def scene(**changed):
        return renderer(**size | {"headings": 36} | changed).scene

    assert scene() is scene(robot=replace(lab, image=lab.image.copy()))
    own = scene(background=floor)
    assert own is scene(background=floor.copy())
    floor[:] = 0
    assert own is not scene(background=floor)
    for changed in (
        {"robot": robsim.load_robot("sheep")},
        {"robot": replace(lab, alignment=3)},
        {"area": (400, 299)},
        {"resolution": (200, 149)},
        {"headings": 0},
        {"background": floor},
        {"adjust_background": lambda background: draw_red_square(background)},
    ):
        assert scene() is not scene(**changed), changed


def small_scene(size):
    image = np.zeros((size, size, 3), np.uint8)
    return small_renderer(floor=(image, image), home=(image, image), area=(size, size)).scene


def test_the_scenes_that_were_not_used_for_longest_go_first():
    cache = SceneCache(maximum_size=3 * small_scene(10).nbytes)
    scenes = {name: cache.get(name, lambda: small_scene(10)) for name in "abc"}
    assert cache.size == cache.maximum_size
    cache.get("a", pytest.fail)
    cache.get("d", lambda: small_scene(10))
    for name in "ac":
        assert cache.get(name, pytest.fail) is scenes[name]
    assert cache.get("b", lambda: small_scene(10)) is not scenes["b"]

    def broken():
        raise ValueError("no such floor")

    with pytest.raises(ValueError, match="no such floor"):
        cache.get("e", broken)
    assert cache.get("e", lambda: small_scene(8)).nbytes == 4 * 3 * 64
