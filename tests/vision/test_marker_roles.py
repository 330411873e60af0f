"""Markers are called by where they sit on the robot, and found by colours of any names."""

import pickle
from dataclasses import asdict, replace

import numpy as np
import pytest

import robsim
from drawn_robots import box, painted
from robsim import ColorClass
from robsim.gui import robot_panel
from robsim.vision import (
    Blob,
    BlobMarker,
    MarkerLayout,
    RobotDefinition,
    add_robot,
    check_colors,
    detect,
    load_robot,
    robot_from_image,
    rotate_robot,
    save_colors,
    save_robot,
    train_markers,
)

COLORS = (
    ColorClass("green", u=(0, 116), v=(0, 104)),
    ColorClass("orange", u=(0, 92), v=(154, 255)),
)
NOTHING_IS_ORANGE = (COLORS[0], ColorClass("orange", u=(0, 1), v=(254, 255)))
PAINTS = ((30, 150, 60, 255), (245, 130, 20, 255))
NAMES = ("green", "orange")
BY_ROLE = {"front": "green", "back": "orange"}
FRONT, BACK = box(240, 150, 320, 250), box(80, 160, 160, 240)
GREEN, ORANGE = BlobMarker(FRONT, "green"), BlobMarker(BACK, "orange")
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
        "markers": {"back": ORANGE, "front": GREEN},
    }
    return RobotDefinition(**(values | changed))


MARKERS = robot().marker_layout()


def simulation(**options):
    options = {"colors": COLORS, "robot": robot(), "measure": True, "headings": None} | options
    return robsim.Simulation(**options, seed=4)


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
        places = dict(zip(roles, (one, other), strict=True))
        assert set(MarkerLayout.from_positions(places).roles) == set(roles)
        with pytest.raises(ValueError, match="marker"):
            MarkerLayout.from_positions(dict(zip(roles, (other, one), strict=True)))


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


def test_a_pair_is_by_role():
    layout = MarkerLayout.from_positions({"front": (20, 0), "back": (-20, 0)})
    place = {"area": 441, "bounding_box": (90, 90, 110, 110)}
    blobs = {
        "red": [Blob("red", centroid=(140, 100), **place)],
        "blue": [Blob("blue", centroid=(100, 100), **place)],
    }
    found = detect(blobs, layout)
    assert list(found.seen) == ["front", "back"]
    assert (
        found.seen == found.measurement.seen == {"front": blobs["red"][0], "back": blobs["blue"][0]}
    )
    np.testing.assert_allclose(found.measurement.pose, (120, 100, 0), atol=1e-9)
    assert pickle.loads(pickle.dumps(found.measurement)) == found.measurement
    assert "back marker" in detect({"red": blobs["red"]}, layout).explanation
    with pytest.raises(ValueError, match=r"seen.*roles"):
        robsim.Measurement((1, 2, 3), seen={"red": blobs["red"][0], "blue": blobs["blue"][0]})


# --- a robot


def test_a_definition_keeps_the_order_and_cannot_be_changed():
    fruit = robot()
    assert list(fruit.markers) == ["front", "back"]
    assert fruit.marker_layout().colors == BY_ROLE
    assert fruit.markers == asdict(fruit)["markers"] == {"front": GREEN, "back": ORANGE}
    with pytest.raises(TypeError):
        fruit.markers["front"] = ORANGE
    with pytest.raises(AttributeError):
        fruit.markers["front"].color = "red"
    for again in (replace(fruit), pickle.loads(pickle.dumps(fruit))):
        assert again == fruit
        assert hash(again) == hash(fruit)
    assert fruit != robot(markers={"front": BlobMarker(FRONT, "red"), "back": ORANGE})
    assert GREEN == pickle.loads(pickle.dumps(GREEN)) != BlobMarker(FRONT, "orange")


def test_a_definition_whose_roles_are_wrong():
    aside = {"right": GREEN, "left": BlobMarker(np.add(BACK, (0, 30)), "orange")}
    for changed, words in (
        ({"alignment": 180}, "front marker"),
        ({"markers": aside}, "right marker"),
        ({"markers": {"red": GREEN, "blue": ORANGE}}, "markers"),
        ({"markers": {"front": GREEN}}, "markers"),
        ({"markers": {"front": GREEN, "back": BlobMarker(BACK, "green")}}, "different colours"),
        ({"markers": {"front": GREEN, "back": BACK}}, r"markers\['back'\].*BlobMarker"),
        (
            {"markers": {"front": GREEN, "back": BlobMarker(FRONT - 9, "orange")}},
            "front marker.*back marker.*overlap",
        ),
    ):
        with pytest.raises((TypeError, ValueError), match=words):
            robot(**changed)


def test_files_name_the_kind_of_a_marker_and_one_that_is_not_there_is_refused(tmp_path):
    save_robot(tmp_path / "fruit", robot())
    file = tmp_path / "fruit/robot.toml"
    whole = robsim.Scenario(robot=robot()).to_toml()
    for text, load in (
        (file.read_text(), lambda text: file.write_text(text) and load_robot(file.parent)),
        (whole, lambda text: robsim.Scenario.from_toml(text).robot),
    ):
        green = 'color = "green"\n'
        named = load(text.replace(green, green + 'kind = "blob"\n'))
        assert load(text).markers == named.markers == robot().markers
        assert load(text.replace(green, "")).markers["front"].color == "red"
        for wrong, words in (
            ('kind = "tag36h11"\n', r"markers\.front\] kind must be one of 'blob', got 'tag36h11'"),
            ("identity = 3\n", r"markers\.front\] there is no key 'identity'"),
            ("color = 3\n", r"markers\.front\] color"),
        ):
            with pytest.raises(ValueError, match=words):
                load(text.replace(green, wrong))


@pytest.mark.long
def test_it_is_saved_loaded_and_tracked_by_a_file_of_these_colours(tmp_path):
    save_colors(tmp_path / "colors.toml", COLORS)
    save_robot(tmp_path / "fruit", robot())
    loaded = load_robot(tmp_path / "fruit")
    assert loaded.markers == {"front": GREEN, "back": ORANGE}
    sim = simulation(
        robot=loaded,
        colors=tmp_path / "colors.toml",
        control=robsim.DriveAround(),
        noise=robsim.GaussianNoise(5),
    )
    trace = sim.run(40)
    assert trace.seen.mean() > 0.95
    assert not trace.is_false.any()
    error = trace.error[trace.seen]
    assert np.sqrt(np.square(error[:, :2]).sum(axis=1).mean()) < 0.1
    assert np.degrees(np.abs(error[:, 2])).max() < 1
    assert set(trace.blobs) == set(NAMES)
    assert trace.info.marker_colors == NAMES
    assert sim.last_step.measurement.seen["front"] in sim.last_step.blobs["green"]
    with pytest.raises(ValueError, match="green and orange"):
        simulation(colors=robsim.load_colors()).run(1)


def test_it_is_found_in_a_frame_also_in_dim_light():
    frame = simulation(start=(300, 400, 0.7), resolution=(600, 600)).frame
    dim = np.rint(frame.image * 0.2).astype(np.uint8)
    for seen, atol in ((frame, 0.05), (robsim.Frame(dim, plane_map=frame.plane_map), 0.1)):
        blobs = robsim.find_blobs(seen, COLORS, markers=MARKERS)
        assert set(blobs) == set(NAMES)
        found = detect(blobs, MARKERS, image=seen, colors=COLORS)
        assert found.measurement is not None, found.explanation
        assert found.by_second_chance == (seen is not frame)
        np.testing.assert_allclose(found.measurement.pose, (300, 400, 0.7), atol=atol)
        assert [blob.color for blob in found.measurement.seen.values()] == list(NAMES)


def test_what_is_missing_is_called_by_its_name(tmp_path):
    frame = simulation().frame
    blobs = robsim.find_blobs(frame, COLORS, markers=MARKERS)
    for name in NAMES:
        found = detect(blobs | {name: []}, MARKERS)
        assert found.reason == f"no {name} blob"
        assert "blue" not in found.explanation
    assert detect({name: [] for name in NAMES}, MARKERS).reason == "no blobs"
    sim = simulation(colors=NOTHING_IS_ORANGE, adjust_background=lambda floor: 0 * floor + 150)
    trace = sim.run(3)
    assert [one.reason for one in sim.missed_detections] == ["no orange blob"]
    trace.save(tmp_path / "run.npz")
    assert (robsim.Trace.load(tmp_path / "run.npz").missed_reasons == "no orange blob").all()


def test_a_scenario_and_a_session_keep_the_names(tmp_path):
    positions = MarkerLayout.from_positions({"front": (20, 0), "back": (-20, 0)}, colors=BY_ROLE)
    scenario = robsim.Scenario(robot=robot(), colors=COLORS, markers=positions, measure=True)
    read = robsim.Scenario.from_toml(scenario.to_toml())
    assert read.robot == robot()
    assert read.markers == positions
    frames = [robsim.Frame(simulation().frame.image, t=0.1 * k) for k in range(2)]
    options = {"colors": COLORS, "robot": robot(), "measure": True}
    with robsim.Experiment(frames, record=tmp_path / "session", **options) as experiment:
        experiment.run()
    session = robsim.trace.Session(tmp_path / "session")
    assert session.markers.colors == BY_ROLE
    assert session.trace.seen.all()


def test_its_colours_are_trained_on_a_recording():
    frames = [simulation(start=(x, 400, 0.3)).frame for x in (200, 900)]
    green, orange = train_markers(frames, MARKERS, colors=COLORS)
    assert (green.color.name, orange.color.name) == NAMES
    blobs = robsim.find_blobs(frames[0], (green.color, orange.color), markers=MARKERS)
    assert robsim.locate(blobs, MARKERS, image=frames[0]) is not None
    with pytest.raises(ValueError, match=r"colors.*green and orange"):
        train_markers(frames, MARKERS)
    with pytest.raises(ValueError, match=r"regions.*'green' and 'orange'"):
        train_markers(frames, MARKERS, regions={"red": (1, 1, 9, 9)})


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
        assert list(made.marker_layout().colors.items()) == list(colors.items())
        assert check_colors(made, COLORS).ok
    assert add_robot("b", made, colors=COLORS).marker_layout().colors == colors
    turned = add_robot("c", robot(), alignment=alignment, colors=COLORS)
    assert turned.marker_layout().colors == colors
    tool = robot_panel(robot=robot(), colors=COLORS)
    tool.turn(alignment)
    assert tool.value.marker_layout().colors == colors
    tool.draw("orange", FRONT)
    with pytest.raises(ValueError, match=r"green.*orange|orange.*green"):
        _ = tool.value
    add_robot("d", robot(), colors=COLORS)
    rotate_robot("d", alignment)
    turned = load_robot("d")
    assert list(turned.marker_layout().colors.items()) == list(colors.items())
    (role,) = (role for role, color in colors.items() if color == "green")
    np.testing.assert_array_equal(turned.markers[role].polygon, FRONT)


@pytest.mark.long
def test_comments_in_a_file_survive_new_roles(user_folder):
    add_robot("mine", "lab")
    file = user_folder / "robots/mine/robot.toml"
    file.write_text(file.read_text().replace('color = "red"', 'color = "red"  # matt paper'))
    rotate_robot("mine", 90)
    text = file.read_text()
    assert load_robot("mine").marker_layout().colors == {"front": "blue", "back": "red"}
    assert '[markers.back]\ncolor = "red"  # matt paper\n' in text
    assert "alignment = 180.0 # degrees clockwise" in text
    assert "[markers.right]" not in text
    rotate_robot("mine", -90)
    assert load_robot("mine").marker_layout().colors == {"right": "red", "left": "blue"}


def test_another_robots_markers_get_other_colours_and_polygons(user_folder):
    known = robot(markers={"front": BlobMarker(FRONT, "red"), "back": BlobMarker(BACK, "blue")})
    options = {"marker_colors": ("green", "orange"), "colors": COLORS}
    made = add_robot("mine", known, markers={"orange": BACK + 1}, **options)
    assert made.markers == {"front": GREEN, "back": BlobMarker(BACK + 1, "orange")}
    with pytest.raises(ValueError, match=r"markers.*green and orange"):
        add_robot("other", known, markers={"red": BACK}, **options)
