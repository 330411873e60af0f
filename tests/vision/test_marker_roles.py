"""Markers are called by where they sit on the robot, and found by their colours."""

import copy
import pickle
from dataclasses import asdict, replace

import numpy as np
import pytest

import robsim
from drawn_robots import box, painted
from robsim import ColorClass
from robsim._core import fitting_roles
from robsim.gui import robot_panel
from robsim.robots import (
    RobotDefinition,
    add_robot,
    load_robot,
    robot_from_image,
    rotate_robot,
    save_robot,
)
from robsim.vision import Blob, MarkerLayout, detect

COLORS = (
    ColorClass("green", u=(0, 116), v=(0, 104)),
    ColorClass("orange", u=(0, 92), v=(154, 255)),
)
PAINTS = ((30, 150, 60, 255), (245, 130, 20, 255))
FRONT, BACK = box(240, 150, 320, 250), box(80, 160, 160, 240)
SQUARE = np.array([(-5.0, -5), (5, -5), (5, 5), (-5, 5)])


def robot(**changed):
    """It faces the right of its picture: green in front, orange at the back."""
    rim = 2 * np.pi * np.arange(40) / 40
    values = {
        "name": "fruit",
        "image": painted(FRONT, BACK, paints=PAINTS),
        "size": 120,
        "alignment": 0,
        "outline": 199.5 + 195 * np.column_stack((np.cos(rim), np.sin(rim))),
        "markers": {"back": BACK, "front": FRONT},
        "marker_colors": {"back": "orange", "front": "green"},
    }
    return RobotDefinition(**(values | changed))


# --- which roles markers have


def test_the_pair_of_roles_that_fits_the_heading_better():
    for one, other, roles in (
        ((0, 9), (0, -9), ("right", "left")),
        ((0, -9), (0, 9), ("left", "right")),
        ((9, 0), (-9, 0), ("front", "back")),
        ((-9, 0), (9, 0), ("back", "front")),
        ((-3, 20), (4, 5), ("right", "left")),
        ((20, -3), (5, 4), ("front", "back")),
        ((7, 7.000001), (0, 0), ("right", "left")),  # a tie
        ((7.000001, 7), (0, 0), ("right", "left")),
    ):
        assert fitting_roles(one, other) == roles


def test_the_shipped_robots():
    colors = {name: load_robot(name).marker_colors for name in ("lab", "robot2", "sheep")}
    assert colors == {
        "lab": {"right": "red", "left": "blue"},
        "robot2": {"front": "blue", "back": "red"},
        "sheep": {"front": "red", "back": "blue"},
    }
    assert MarkerLayout(40, 10).roles == ("right", "left")


# --- a layout


def test_a_layout_has_all_by_role_in_one_order():
    layout = MarkerLayout.from_positions(
        {"back": (-9, 1), "front": (9, 2)}, areas={"front": 30}, colors={"back": "b", "front": "f"}
    )
    assert layout.roles == ("front", "back")
    assert list(layout.colors.items()) == [("front", "f"), ("back", "b")]
    assert [place.tolist() for place in layout.positions.values()] == [[9, 2], [-9, 1]]
    assert layout.areas["front"] == 30
    assert np.isnan(layout.areas["back"])
    assert layout.polygons is None
    assert eval(repr(layout), {"MarkerLayout": MarkerLayout}) == layout
    for again in (copy.deepcopy(layout), pickle.loads(pickle.dumps(layout))):
        assert again == layout
        assert hash(again) == hash(layout)
    across = MarkerLayout.from_positions({"right": (9, 2), "left": (-9, 1)})
    along = MarkerLayout.from_positions({"front": (9, 2), "back": (-9, 1)})
    assert across != along
    assert along.colors == {"front": "red", "back": "blue"}


def test_roles_that_are_none_or_not_true():
    for markers, words in (
        ({"right": (0, -9), "left": (0, 9)}, "right marker"),
        ({"front": (-14 + 5e-15, 9), "back": (-14, -9)}, "front marker"),
        ({"front": (-9, 0), "back": (9, 0)}, "front marker"),
        ({"front": (3, 9), "back": (3, -9)}, "front marker"),
        *(
            (wrong, "roles")
            for wrong in (
                *({"red": (0, 9), "blue": (0, -9)}, {"right": (0, 9), "back": (0, -9)}),
                *({"right": (0, 9)}, {"right": (0, 9), "left": (0, 0), "front": (9, 9)}, {}),
            )
        ),
    ):
        with pytest.raises(ValueError, match=words):
            MarkerLayout.from_positions(markers)
        with pytest.raises(ValueError, match=words):
            MarkerLayout.from_markers({role: SQUARE + place for role, place in markers.items()})


def test_what_is_given_by_other_roles():
    for name, value in {"areas": 9.0, "polygons": SQUARE, "colors": "red"}.items():
        with pytest.raises(ValueError, match=rf"^{name}.*roles"):
            MarkerLayout.from_positions(
                {"right": (0, 9), "left": (0, -9)}, **{name: {"front": value, "back": value}}
            )


def test_a_pair_is_by_role():
    layout = MarkerLayout.from_positions({"front": (20, 0), "back": (-20, 0)})
    place = {"area": 441, "bounding_box": (90, 90, 110, 110)}
    blobs = {
        "red": [Blob("red", centroid=(140, 100), **place)],
        "blue": [Blob("blue", centroid=(100, 100), **place)],
    }
    found = detect(blobs, layout)
    assert list(found.pair) == ["front", "back"]
    assert (
        found.pair == found.measurement.pair == {"front": blobs["red"][0], "back": blobs["blue"][0]}
    )
    np.testing.assert_allclose(found.measurement.pose, (120, 100, 0), atol=1e-9)
    assert pickle.loads(pickle.dumps(found.measurement)) == found.measurement
    assert "back marker" in detect({"red": blobs["red"]}, layout).explanation
    with pytest.raises(ValueError, match=r"pair.*roles"):
        robsim.Measurement((1, 2, 3), pair={"red": blobs["red"][0], "blue": blobs["blue"][0]})


# --- a robot


def test_a_definition_keeps_the_order_and_cannot_be_changed():
    fruit = robot()
    assert list(fruit.markers) == ["front", "back"]
    assert fruit.marker_colors == {"front": "green", "back": "orange"}
    with pytest.raises(TypeError):
        fruit.markers["front"] = BACK
    for again in (replace(fruit), pickle.loads(pickle.dumps(fruit))):
        assert again == fruit
        assert hash(again) == hash(fruit)
        with pytest.raises(ValueError, match="read-only"):
            again.markers["front"][0] = 1
    assert asdict(fruit)["marker_colors"] == {"front": "green", "back": "orange"}
    assert fruit != robot(marker_colors={})
    assert robot(marker_colors={}).marker_colors == {"front": "red", "back": "blue"}


def test_a_definition_whose_roles_are_wrong():
    aside = {"right": FRONT, "left": np.add(BACK, (0, 30))}
    for changed, words in (
        ({"alignment": 180}, "front marker"),
        ({"markers": {"right": FRONT, "left": BACK}}, "marker_colors"),
        ({"markers": aside, "marker_colors": {}}, "right marker"),
        ({"markers": {"red": FRONT, "blue": BACK}}, "markers"),
        ({"markers": {"front": FRONT}}, "markers"),
        ({"marker_colors": {"red": "green", "blue": "orange"}}, "marker_colors"),
        ({"markers": {"front": FRONT, "back": 5}}, r"markers\['back'\]"),
        ({"markers": {"front": FRONT, "back": FRONT - 9}}, "front marker.*back marker.*overlap"),
    ):
        with pytest.raises(ValueError, match=words):
            robot(**changed)


def test_a_robot_with_green_in_front_and_orange_behind_is_saved_loaded_and_tracked(tmp_path):
    save_robot(tmp_path, robot())
    text = (tmp_path / "robot.toml").read_text()
    assert '\n[markers.front]\ncolor = "green"\npolygon = [\n' in text
    assert text.index("[markers.front]") < text.index("[markers.back]")
    loaded = load_robot(tmp_path)
    assert loaded.marker_colors == robot().marker_colors
    np.testing.assert_array_equal(loaded.markers["back"], BACK)
    sim = robsim.Simulation(
        robot=loaded,
        colors=COLORS,
        measure=True,
        control=robsim.DriveAround(),
        headings=None,
        seed=2,
    )
    trace = sim.run(40)
    assert trace.seen.mean() > 0.9
    assert not trace.is_false.any()
    assert trace.info.marker_colors == ("green", "orange")
    assert sim.last_step.measurement.pair["front"].color == "green"
    assert sim.last_step.measurement.pair["front"] in sim.last_step.blobs["green"]


# --- drafts


@pytest.mark.long
@pytest.mark.parametrize(
    ("alignment", "colors"),
    [
        (90, {"right": "green", "left": "orange"}),
        (180, {"front": "orange", "back": "green"}),
        (-30, {"front": "green", "back": "orange"}),
    ],
)
def test_the_roles_of_a_draft_follow_from_its_heading(alignment, colors, user_folder):
    image = robot().image
    for names in (("green", "orange"), ("orange", "green")):
        made = robot_from_image("a", image, alignment=alignment, colors=COLORS, marker_colors=names)
        assert list(made.marker_colors.items()) == list(colors.items())
    assert add_robot("b", made, colors=COLORS).marker_colors == colors
    assert add_robot("c", robot(), alignment=alignment, colors=COLORS).marker_colors == colors
    tool = robot_panel(robot=robot(), colors=COLORS)
    tool.turn(alignment)
    assert tool.value.marker_colors == colors
    add_robot("d", robot(), colors=COLORS)
    rotate_robot("d", alignment)
    turned = load_robot("d")
    assert list(turned.marker_colors.items()) == list(colors.items())
    (role,) = (role for role, color in colors.items() if color == "green")
    np.testing.assert_array_equal(turned.markers[role], FRONT)


@pytest.mark.long
def test_comments_in_a_file_survive_new_roles(user_folder):
    add_robot("mine", "lab")
    file = user_folder / "robots/mine/robot.toml"
    file.write_text(file.read_text().replace('color = "red"', 'color = "red"  # matt paper'))
    rotate_robot("mine", 90)
    text = file.read_text()
    assert load_robot("mine").marker_colors == {"front": "blue", "back": "red"}
    assert '[markers.back]\ncolor = "red"  # matt paper\n' in text
    assert "alignment = 180.0   # degrees clockwise" in text
    assert "[markers.right]" not in text
    rotate_robot("mine", -90)
    assert load_robot("mine").marker_colors == {"right": "red", "left": "blue"}


def test_another_robots_markers_get_other_colours_and_polygons(user_folder):
    known = robot(marker_colors={"front": "red", "back": "blue"})
    options = {"marker_colors": ("green", "orange"), "colors": COLORS}
    made = add_robot("mine", known, markers={"orange": BACK + 1}, **options)
    assert made.marker_colors == {"front": "green", "back": "orange"}
    np.testing.assert_array_equal(made.markers["back"], BACK + 1)
    with pytest.raises(ValueError, match=r"markers.*green and orange"):
        add_robot("other", known, markers={"red": BACK}, **options)
