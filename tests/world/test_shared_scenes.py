"""Scenes are made once and shared; renderers draw on images of their own."""

import threading
from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim.simulation import Renderer
from robsim.simulation._options import background_value
from robsim.simulation._world.scene import as_floor, draw_red_square, make_scene, scaled_floor
from robsim.simulation._world.scene_cache import SceneCache
from scenes import renderer, small_renderer

POSE = (400.0, 500.0, 0.7)


def scene(**changed):
    options = {"robot": robsim.load_robot("lab"), "area": (400, 300), "resolution": (200, 150)}
    options |= {"headings": 36, "background": None, "adjust_background": draw_red_square}
    return make_scene(**(options | changed))


def floor(seed):
    pixels = np.random.default_rng(seed).integers(0, 256, (300, 400, 3), dtype=np.uint8)
    return as_floor(pixels)


def test_renderers_of_one_scene_draw_the_same_and_do_not_disturb_each_other(rng):
    first = renderer(headings=36, resolution=(480, 480))
    second = Renderer(first.scene)
    assert second.scene is first.scene
    alone = renderer(
        headings=36, resolution=(480, 480), adjust_background=lambda b: draw_red_square(b)
    )
    for _ in range(8):
        pose, other = ((*rng.uniform(0, 1200, 2), rng.uniform(-3, 3)) for _ in range(2))
        image = first.render(pose)
        second.render(other)
        np.testing.assert_array_equal(image, alone.render(pose))


def test_renderers_of_one_scene_in_threads():
    whole = small_renderer(headings=36).scene
    expected = [small_renderer(headings=36).render((5, 4, h)).copy() for h in range(7)]
    wrong = []

    def draw(out):
        own = Renderer(whole)
        for k in range(200):
            own.render((5, 4, k % 7), out=out)
            if (out != expected[k % 7]).any():
                wrong.append(k)

    threads = [
        threading.Thread(target=draw, args=(np.zeros((8, 10, 3), np.uint8),)) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_a_scene_of_the_same_is_the_same():
    robot = robsim.load_robot("lab")
    assert scene() is scene(robot=replace(robot, image=robot.image.copy()))
    assert scene(background=floor(1)) is scene(background=floor(1))


@pytest.mark.parametrize(
    "changed",
    [
        {"robot": robsim.load_robot("sheep")},
        {"robot": replace(robsim.load_robot("lab"), alignment=3)},
        {"area": (400, 299)},
        {"resolution": (200, 149)},
        {"headings": 0},
        {"background": floor(1)},
        {"adjust_background": lambda background: draw_red_square(background)},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_a_scene_of_something_else_is_another(changed):
    assert scene() is not scene(**changed)


def test_an_own_adjust_background_is_called_each_time():
    calls = []

    def adjust(background):
        calls.append(background.shape)
        return background

    assert scene(adjust_background=adjust) is not scene(adjust_background=adjust)
    assert len(calls) == 2


def test_a_floor_does_not_change_with_the_array_it_was_made_of():
    pixels = np.full((300, 400, 3), 90, np.uint8)
    floor = as_floor(pixels)
    pixels[:] = 200
    assert (floor.pixels == 90).all()
    assert floor == as_floor(np.full((300, 400, 3), 90, np.uint8))


def test_a_floor_is_scaled_once():
    small = as_floor(np.full((3, 4, 3), 90, np.uint8))
    scaled = scaled_floor(small, (400, 300))
    assert scaled.pixels.shape == (300, 400, 3)
    assert scaled_floor(as_floor(small.pixels), (400, 300)) is scaled
    assert scaled_floor(scaled, (400, 300)) is scaled
    assert scaled_floor(None, (400, 300)) is None


def test_a_changed_file_is_another_floor(tmp_path):
    file = tmp_path / "floor.png"
    robsim.imaging.save_image(file, np.full((3, 4, 3), 90, np.uint8))
    first = background_value(file)
    assert background_value(file) is first
    robsim.imaging.save_image(file, np.full((6, 8, 3), 120, np.uint8))
    assert (background_value(str(file)).pixels == 120).all()


@pytest.mark.parametrize("background", [None, floor(2)], ids=["shipped", "own"])
def test_the_same_scene_again_is_neither_made_nor_read(background, monkeypatch):
    first = scene(background=background)
    monkeypatch.setattr("robsim.simulation._world.scene._composed", pytest.fail)
    monkeypatch.setattr("robsim.simulation._world.scene.digest", pytest.fail)
    monkeypatch.setattr("robsim.robots._definition.digest", pytest.fail)
    assert scene(background=background) is first


def small_scene(size):
    image = np.zeros((size, size, 3), np.uint8)
    return small_renderer(floor=(image, image), home=(image, image), area=(size, size)).scene


def test_the_scenes_that_were_not_used_for_longest_go_first():
    cache = SceneCache(maximum_size=3 * small_scene(10).nbytes)
    scenes = {name: cache.get(name, lambda: small_scene(10)) for name in "abc"}
    assert cache.size == cache.maximum_size
    cache.get("a", pytest.fail)
    cache.get("d", lambda: small_scene(10))
    for name in "acd":
        assert cache.get(name, pytest.fail) is scenes.get(name, cache.get(name, pytest.fail))
    assert cache.get("b", lambda: small_scene(10)) is not scenes["b"]


def test_a_scene_larger_than_the_cache_is_kept_until_the_next_one():
    cache = SceneCache(maximum_size=10)
    large = cache.get("large", lambda: small_scene(40))
    assert cache.get("large", pytest.fail) is large
    cache.get("next", lambda: small_scene(10))
    assert cache.get("large", lambda: small_scene(40)) is not large


def test_an_error_is_not_kept():
    cache = SceneCache(maximum_size=1000)

    def broken():
        raise ValueError("no such floor")

    with pytest.raises(ValueError, match="no such floor"):
        cache.get("a", broken)
    assert cache.get("a", lambda: small_scene(8)).nbytes == 4 * 3 * 64
