"""A robot definition is a value: equal by content, unchangeable, read once."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim.robots import RobotDefinition, load_robot, save_robot
from robsim.robots._lookup import as_robot
from robsim.vision._color_files import SHIPPED_COLORS, as_colors

ARRAYS = {
    "image": lambda robot: robot.image,
    "centre": lambda robot: robot.centre,
    "outline": lambda robot: robot.outline,
    "front": lambda robot: robot.markers["front"],
    "back": lambda robot: robot.markers["back"],
}


def definition(**changed):
    values = {"name": "toy", "image": np.zeros((10, 20, 4), np.uint8), "size": 40.0}
    values |= {"alignment": 0.0, "outline": [[0, 0], [19, 0], [19, 9], [0, 9]]}
    values |= {"front": [[14, 6], [17, 6], [17, 9]], "back": [[2, 6], [5, 6], [5, 9]]} | changed
    markers = {role: values.pop(role) for role in ("front", "back")}
    return RobotDefinition(markers=markers, **values)


def test_equal_by_content():
    robot, same = definition(), definition(image=np.zeros((10, 20, 4), np.uint8), size=40)
    assert robot == same
    assert hash(robot) == hash(same)
    assert len({robot, same, load_robot("lab")}) == 2
    assert robot != "toy"


OTHER_IMAGE = np.zeros((10, 20, 4), np.uint8)
OTHER_IMAGE[3, 4, 1] = 1


@pytest.mark.parametrize(
    "changed",
    [
        {"name": "other"},
        {"image": OTHER_IMAGE},
        {"image": OTHER_IMAGE[:, ::-1]},
        {"size": 41.0},
        {"alignment": 1.0},
        {"outline": [[0, 0], [19, 0], [19, 9.1], [0, 9]]},
        {"front": [[14, 6], [17, 6], [17, 8]]},
        {"back": [[2, 6], [5, 6], [5, 8]]},
        {"centre": [9, 4]},
        {"maximum_blobs": 8},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_different_in_any_part(changed):
    assert definition() != definition(**changed)


@pytest.mark.parametrize("name", ARRAYS)
def test_nobody_can_change_it(name):
    image = np.zeros((10, 20, 4), np.uint8, order="F")
    robot = definition(image=image)
    image[:] = 9
    array = ARRAYS[name](robot)
    assert array.flags.c_contiguous
    assert robot == definition()
    for kept in (robot, pickle.loads(pickle.dumps(robot))):
        with pytest.raises(ValueError, match="read-only"):
            ARRAYS[name](kept)[0] = 1
        with pytest.raises(ValueError, match="WRITEABLE"):
            ARRAYS[name](kept).setflags(write=True)


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda r: pickle.loads(pickle.dumps(r)), replace]
)
def test_copies_are_equal(copied):
    robot = load_robot("lab")
    again = copied(robot)
    assert again == robot
    assert hash(again) == hash(robot)
    assert again.radius == robot.radius
    np.testing.assert_array_equal(
        again.marker_layout().positions["right"], robot.marker_layout().positions["right"]
    )


def test_what_follows_from_it_is_computed_once():
    robot = load_robot("lab")
    assert robot.marker_layout() is robot.marker_layout()
    assert replace(robot, size=60).radius == pytest.approx(robot.radius / 2)


# --- read once


@pytest.mark.parametrize("load", [load_robot, as_robot])
@pytest.mark.parametrize("name", ["lab", "LAB", None])
def test_a_robot_is_loaded_once(load, name, monkeypatch):
    robot = load("lab")
    monkeypatch.setattr("robsim.robots._files.read_toml", pytest.fail)
    assert load(name) is robot


@pytest.fixture
def folder(tmp_path):
    save_robot(tmp_path, definition())
    return tmp_path


def test_a_changed_definition_is_read_again(folder):
    robot = load_robot(folder)
    assert load_robot(folder) is robot
    toml = folder / "robot.toml"
    toml.write_text(toml.read_text().replace("size = 40.0", "size = 400.0"))
    assert load_robot(folder).size == 400
    assert robot.size == 40


def test_a_changed_image_is_read_again(folder):
    robot = load_robot(folder)
    Image.fromarray(np.full((10, 20, 4), 77, np.uint8)).save(folder / "robot.png")
    assert (load_robot(folder).image == 77).all()
    assert not robot.image.any()


def test_files_that_are_gone_are_noticed(folder):
    load_robot(folder)
    (folder / "robot.png").unlink()
    with pytest.raises(ValueError, match=r"robot definition .*robot\.toml: .*robot\.png"):
        load_robot(folder)


def test_the_shipped_colours_are_read_once(monkeypatch):
    assert robsim.load_colors() is as_colors(None)
    assert robsim.load_colors(SHIPPED_COLORS)[0].name == robsim.load_colors()[0].name
    monkeypatch.setattr("robsim.vision._color_files.read_toml", pytest.fail)
    assert robsim.load_colors() is as_colors(None)
