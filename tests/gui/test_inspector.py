"""A step as a tree."""

import io
import json
import threading

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import panel_of
from robsim.gui.panels.analysis.inspector import child_of, nodes_of, picture_of


def named(nodes):
    return {node["name"]: node for node in nodes}


def tree(browser, *path, k=None):
    browser.say("inspect", k=k, path=[*path])
    head, _ = browser.take("tree", path=[*path])
    return head["k"], named(head["nodes"])


@pytest.fixture(scope="module")
def simulation():
    simulation = robsim.Simulation(measure=True, estimate_parameters=True, seed=1)
    simulation.run(8)
    return simulation


def test_the_newest_step_is_shown_level_by_level(simulation):
    with panel_of(simulation) as (_, browser):
        browser.take("frame")
        k, step = tree(browser)
        assert k == 7
        assert list(step)[:4] == ["k", "t", "dt", "last_u"]
        assert step["k"] == {"name": "k", "text": "7", "kind": "number", "more": False}
        assert step["parameters"]["text"].startswith("3 x 5 values: ")
        assert step["estimate"]["kind"] == "none"
        assert step["blobs"]["text"] == "dict of 2: blue, red"
        _, blob = tree(browser, "blobs", "red", "[1]")
        wanted = simulation.last_step.blobs["red"][1]
        assert blob["area"]["text"] == str(wanted.area)
        _, estimator = tree(browser, "estimator")
        assert estimator["forgetting"]["text"] == "1"


def test_a_reset_that_fails_leaves_no_step_of_the_run_before():
    starts = []

    def define_model():
        starts.append(True)
        if len(starts) > 1:
            raise ValueError("no second start")
        return robsim.RobotModel(robsim.RobotParameters())

    with panel_of(robsim.Simulation(define_model=define_model, seed=1)) as (_, browser):
        browser.press("step")
        browser.take("state", k=0)
        assert tree(browser)[0] == 0
        browser.press("reset")
        browser.take("state", state="failed", steps=0)
        assert tree(browser) == (None, {})


def test_a_past_step_has_what_the_trace_and_its_frame_have(simulation):
    trace = simulation.trace
    with panel_of(simulation) as (_, browser):
        k, step = tree(browser, k=3)
        assert k == 3
        assert step["t"]["text"] == f"{trace.t[3]:.6g}"
        assert step["u"]["text"] == "[" + ", ".join(f"{volt:.6g}" for volt in trace.u[3]) + "]"
        _, pose = tree(browser, "measurement", k=3)
        assert pose["pose"]["full"] == str(trace.pose_measured[3].tolist())
        _, frame = tree(browser, "frame", k=3)
        assert frame["image"]["text"].startswith("1200 x 1200 x 3 values (uint8): ")
        _, image = tree(browser, "frame", "image", k=3)
        assert len(image) == 200
        assert "only the first 200" in image["..."]["text"]


def test_what_is_not_there_has_no_nodes(simulation):
    with panel_of(simulation) as (_, browser):
        assert tree(browser, "frame", "nonsense") == (7, {})
        assert tree(browser, k=1000) == (None, {})
    with panel_of(robsim.Simulation(seed=1)) as (_, browser):
        browser.take("frame")
        _, step = tree(browser)
        assert step["u"]["kind"] == "missing"  # it is not decided yet


def test_while_a_callback_keeps_the_step_the_rest_is_shown():
    inside, is_free = threading.Event(), threading.Event()

    def control(step):
        inside.set()
        is_free.wait(300)
        return 0, 0

    simulation = robsim.Simulation(estimate_parameters=True, seed=1, control=control)
    with panel_of(simulation) as (_, browser):
        browser.take("frame")
        browser.press("step")
        inside.wait(300)
        _, step = tree(browser)
        is_free.set()
        assert step["estimator"]["kind"] == "missing"
        assert step["k"]["kind"] == "number"


class Foreign:
    """An object of a user's, whose code must not run."""

    def __getattribute__(self, *_):
        raise AssertionError("asked for an attribute, a text, a length or items")

    __repr__ = __len__ = __iter__ = __getattribute__


class OwnList(list):
    __len__ = __iter__ = vars(Foreign)["__len__"]


class OwnDict(dict):
    __len__ = items = vars(Foreign)["__len__"]


def test_of_foreign_objects_only_what_they_store_is_looked_at():
    value = Foreign.__new__(Foreign)
    object.__getattribute__(value, "__dict__").update(
        gain=0.5, me=value, own=OwnDict(a=1), row=OwnList("ab")
    )
    nodes = named(nodes_of({"value": value, 3: None}))
    assert nodes["value"] == {"name": "value", "text": "Foreign", "kind": "object", "more": True}
    assert nodes["3"]["kind"] == "none"
    inside = named(nodes_of(value))
    assert list(inside) == ["gain", "me", "own", "row"]
    assert named(nodes_of(child_of(value, "own")))["a"]["text"] == "1"
    assert inside["row"]["text"] == "OwnList of 2"
    assert [node["text"] for node in nodes_of(child_of(value, "row"))] == ["'a'", "'b'"]


TEXTS = [
    (True, "number", "True"),
    (float("nan"), "number", "nan"),
    ("a\nb", "text", r"'a\nb'"),
    ("x" * 10**6, "text", "'" + "x" * 295 + " ..."),
    (np.arange(3, dtype=np.uint8), "array", "[0, 1, 2] (uint8)"),
    (np.eye(3), "array", "3 x 3 values: 1, 0, 0, 0, 1, 0, ..."),
    (np.zeros((2, 0)), "array", "2 x 0 values"),
    (np.array(0.25), "array", "0.25"),
    (np.array([Foreign, None]), "array", "[type Foreign, None] (object)"),
    ([], "list", "empty"),
    ({1, 2}, "list", "set of 2"),
    (dict.fromkeys(range(7)), "dict", "dict of 7: 0, 1, 2, 3, 4, 5, ..."),
    (np.sin, "object", "ufunc"),
    (print, "code", "builtin_function_or_method print"),
    (robsim.Spin(0.5), "object", repr(robsim.Spin(0.5))),
]
ROUNDED = [
    (0.1 + 0.2, "0.3", "0.30000000000000004"),
    (-1 / 3e9, "-3.33333e-10", "-3.333333333333333e-10"),
    (1 / 3 - 2j / 3, "(0.333333-0.666667j)", "(0.3333333333333333-0.6666666666666666j)"),
    (1700000000.123, "1700000000", "1700000000.123"),
    (np.array([2 / 3, 1.0]), "[0.666667, 1]", "[0.6666666666666666, 1.0]"),
    (robsim.Spin(1 / 3), "Spin(voltage=0.333333)", repr(robsim.Spin(1 / 3))),
    (1234567890123, "1234567890123", None),
    ("0.30000000000000004", "'0.30000000000000004'", None),
]


def test_text_of_a_value_whose_numbers_are_rounded_and_can_be_had_in_full():
    for value, kind, text in TEXTS:
        (node,) = nodes_of([value])
        assert (node["kind"], node["text"]) == (kind, text)
        json.dumps(node, allow_nan=False)
    for value, text, full in ROUNDED:
        (node,) = nodes_of([value])
        assert (node["text"], node.get("full")) == (text, full)


def test_a_level_is_bounded():
    (huge,) = nodes_of([10**5000])
    assert huge["text"] == "a number of 16610 bits"
    assert len(nodes_of(range(3))) == 0
    nodes = nodes_of(list(range(100_000)))
    assert len(nodes) == 200
    assert nodes[-1]["text"] == "only the first 200 are shown"
    with pytest.raises(KeyError):
        child_of(list(range(1000)), "[500]")


def test_a_large_array_is_told_as_a_picture_and_a_small_one_by_its_rows(simulation):
    with panel_of(simulation) as (_, browser):
        browser.say("inspect", k=3, path=["frame", "image"])
        head, buffers = browser.take("tree", path=["frame", "image"])
        shown = np.array(Image.open(io.BytesIO(buffers[0])))
        wanted = simulation.render_step(3).image[::3, ::3]
        assert head["picture"] == {"size": [1200, 1200]}
        np.testing.assert_array_equal(shown, wanted)
        browser.say("inspect", k=3, path=["parameters"])
        head, buffers = browser.take("tree", path=["parameters"])
        assert [node["text"].count(", ") for node in head["nodes"]] == [4, 4, 4]
        assert (head["picture"], len(buffers)) == (None, 0)


def test_a_plane_of_numbers_is_grey_between_its_ends():
    heights = np.arange(400.0).reshape(20, 20)
    heights[0, 0] = np.nan
    about, picture = picture_of(heights)
    assert about == {"size": [20, 20], "low": 1.0, "high": 399.0}
    shown = np.array(Image.open(io.BytesIO(picture)))
    assert (shown[0, 1], shown[-1, -1]) == (0, 255)
    assert picture_of(np.full((20, 20), np.inf))[0] == {"size": [20, 20], "low": 0.0, "high": 0.0}
    mask = np.eye(20, dtype=bool)
    assert np.array_equal(np.array(Image.open(io.BytesIO(picture_of(mask)[1]))) == 255, mask)
    assert picture_of(np.zeros((20, 3))) is None
    assert picture_of(np.zeros((0, 3))) is None
