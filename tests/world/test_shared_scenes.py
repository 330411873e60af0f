"""Scenes are made once and shared; renderers draw on images of their own."""

from dataclasses import replace

import numpy as np
import pytest

import robsim
from robsim._core import Renderer
from robsim.simulation import draw_red_square
from robsim.simulation.world.scene import SceneCache
from scenes import renderer, small_renderer
from threads import together


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
