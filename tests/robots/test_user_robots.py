"""A user's own robots, and the robot in use."""

import os
import shutil
import tomllib
import unicodedata
from dataclasses import replace

import numpy as np
import platformdirs
import pytest
from PIL import Image

from drawn_robots import box, painted, random_robot
from robsim import DriveAround, Simulation
from robsim.vision import (
    MarkerLayout,
    add_robot,
    default_robot,
    load_robot,
    remove_robot,
    reset_default_robot,
    robot_names,
    rotate_robot,
    save_robot,
    set_default_robot,
)
from sizes import thorough

pytestmark = [pytest.mark.kernels, pytest.mark.long, pytest.mark.usefixtures("user_folder")]

SHIPPED = ["lab", "robot2", "sheep"]
RED, BLUE = box(240, 240, 319, 319), box(80, 240, 159, 319)


@pytest.fixture
def photo(tmp_path):
    """A picture's file."""
    file = tmp_path / "photo.png"
    Image.fromarray(painted(RED, BLUE)).save(file)
    return file


def files(folder):
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


def test_the_user_folder(user_folder, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("ROBSIM_DATA", "~/here")
    add_robot("mine", "lab")
    assert (tmp_path / "home/here/robots/mine").is_dir()
    monkeypatch.setenv("ROBSIM_DATA", "")
    add_robot("mine", "lab")
    assert (platformdirs.user_data_path("robsim") / "robots/mine").is_dir()
    assert not user_folder.exists()


def test_the_choice_is_what_load_robot_loads(user_folder):
    assert robot_names() == SHIPPED
    assert default_robot() == load_robot().name == "lab"
    reset_default_robot()
    assert not user_folder.exists()  # looking writes nothing
    set_default_robot("SHEEP")
    assert default_robot() == load_robot().name == Simulation().robot.name == "sheep"
    assert load_robot("lab").name == "lab"
    reset_default_robot()
    assert load_robot().name == "lab"


# --- adding


def test_a_robot_from_each_kind_of_source(user_folder, photo, tmp_path):
    save_robot(tmp_path / "folder", load_robot("lab"))
    sources = [load_robot("lab"), "LAB", tmp_path / "folder", photo, str(photo), "robot-0"]
    for number, source in enumerate(sources):
        assert add_robot(f"robot-{number}", source).name == f"robot-{number}"
    assert robot_names() == SHIPPED + [f"robot-{number}" for number in range(6)]
    assert files(user_folder / "robots/robot-0") == ["robot.png", "robot.toml"]
    distances = [load_robot(f"robot-{number}").marker_layout().distance for number in range(6)]
    assert distances == pytest.approx([43] * 3 + [48] * 2 + [43], abs=0.02)


def test_what_is_added_is_what_is_loaded(rng):
    drawn = random_robot(rng)
    added = add_robot("mine", drawn)
    loaded = load_robot("mine")
    for robot in (added, loaded):
        np.testing.assert_array_equal(robot.image, drawn.image)
        assert (robot.size, robot.alignment) == (drawn.size, drawn.alignment)
        for name in ("centre", "outline"):
            np.testing.assert_allclose(getattr(robot, name), getattr(drawn, name), atol=0.0051)
        for role, marker in drawn.markers.items():
            np.testing.assert_allclose(robot.markers[role].polygon, marker.polygon, atol=0.0051)


def test_given_values_override_those_of_the_source(photo):
    robot = add_robot("mine", "lab", size=90, alignment=-90, centre=(240, 250),
                      markers={"red": RED, "blue": BLUE},
                      outline=box(5, 5, 470, 470), ignore_colors=True)  # fmt: skip
    assert (robot.name, robot.size, robot.alignment) == ("mine", 90, -90)
    np.testing.assert_array_equal(robot.centre, (240, 250))
    np.testing.assert_array_equal(robot.markers["left"].polygon, RED)
    np.testing.assert_array_equal(robot.outline, box(5, 5, 470, 470))
    assert add_robot("other", photo, size=90).size == 90


@pytest.mark.filterwarnings("ignore:the image has no transparency")
def test_other_kinds_of_pictures(tmp_path):
    image = Image.fromarray(painted(RED, BLUE)).convert("RGB")
    image.save(tmp_path / "photo.jpg")
    assert add_robot("jpg", tmp_path / "photo.jpg").marker_layout().distance == pytest.approx(
        48, abs=0.2
    )
    image.convert("L").save(tmp_path / "grey.png")
    markers = {"red": RED, "blue": BLUE}
    grey = add_robot("grey", tmp_path / "grey.png", markers=markers, ignore_colors=True)
    assert grey.image.shape == (400, 400, 4)


def test_a_large_robot_is_scaled_down():
    lab = load_robot("lab")
    image = np.repeat(np.repeat(lab.image, 3, axis=0), 3, axis=1)[:, 60:-60]  # high
    moved = 1 - np.array((60, 0))
    points = {name: 3 * getattr(lab, name) + moved for name in ("centre", "outline")}
    points["markers"] = {
        role: replace(marker, polygon=3 * marker.polygon + moved)
        for role, marker in lab.markers.items()
    }
    robot = add_robot("mine", replace(lab, image=image, size=120 * 1320 / 1440, **points))
    assert max(robot.image.shape) == 1000
    assert robot.marker_layout().distance == pytest.approx(43, abs=0.05)
    assert robot.marker_layout().offset == pytest.approx(14, abs=0.05)


def test_a_robot_is_replaced_only_when_asked_whatever_the_case(user_folder):
    add_robot("Mine", "lab")
    assert load_robot("mINE").name == "Mine"
    with pytest.raises(ValueError, match=r"already.*'Mine': .* overwrite=True"):
        add_robot("mine", "lab", size=60)
    assert load_robot("mine").size == 120
    add_robot("MINE", "Mine", size=60, overwrite=True)
    assert load_robot("mine").size == 60
    assert robot_names() == [*SHIPPED, "MINE"]
    assert files(user_folder) == ["robots/MINE/robot.png", "robots/MINE/robot.toml"]
    set_default_robot("mine")
    assert default_robot() == "MINE"


def test_names(user_folder):
    plain = ["", "..", "a/b", "a\\b", "C:x", "a.b", "-a", "_a", "x" * 41, "\0", "a\n", "a*"]
    for name in (*plain, "½", "\u0308a", "con", "Lpt9", "aux"):
        with pytest.raises(ValueError, match="name must"):
            add_robot(name, "lab")
    assert not user_folder.exists()
    for name in ("0", "x" * 40, "A-b_9", "com10", "größe-2", "लैब"):
        assert add_robot(name, "lab").name == name
    set_default_robot("größe-2".upper())
    assert default_robot() == "größe-2"
    # An accent may be a character of its own.
    with pytest.raises(ValueError, match="already"):
        add_robot(unicodedata.normalize("NFD", "größe-2"), "lab")


@pytest.mark.parametrize("name", ["robot2", "LAB"])
def test_shipped_robots_stay_as_they_are(user_folder, name):
    for attempt in (
        lambda: add_robot(name, "lab"),
        lambda: add_robot(name, "lab", overwrite=True),
        lambda: rotate_robot(name, 90),
        lambda: remove_robot(name),
    ):
        with pytest.raises(ValueError, match=f"cannot be changed: .*my-{name.lower()}"):
            attempt()
    assert not user_folder.exists()


def test_sources_that_are_none_and_colours_that_are_not_seen(user_folder, photo, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.png").write_text("hello")
    for source, said in (
        ("no such", r"\bsource\b.*lab, robot2, sheep"),
        (tmp_path / "empty", r"empty has no robot\.toml"),
        (tmp_path / "text.png", r"text\.png"),
    ):
        with pytest.raises(ValueError, match=said):
            add_robot("mine", source)
    colors = tmp_path / "colors.toml"
    colors.write_text("[red]\nv = [250, 255]\n[blue]\nu = [160, 255]\nv = [0, 140]\n")
    with pytest.raises(ValueError, match=r"right marker \(red\): 0.0 % .*ignore_colors=True"):
        add_robot("mine", "lab", colors=colors)
    with pytest.raises(ValueError, match="red marker: nothing"):
        add_robot("mine", photo, colors=colors)
    assert not user_folder.exists()
    assert add_robot("mine", "lab", colors=colors, ignore_colors=True).name == "mine"


# --- files: what fails in the middle is in tests/files/test_writing.py


def test_a_failing_add_leaves_nothing_behind(user_folder, monkeypatch):
    def broken(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(os, "fsync", broken)
    with pytest.raises(OSError, match="the disk is full"):
        add_robot("mine", "lab")
    assert files(user_folder) == []
    assert robot_names() == SHIPPED


def test_an_overwrite_leaves_one_image(user_folder):
    for source in ("lab", "sheep", "sheep"):
        added = add_robot("mine", source, overwrite=True)
        assert load_robot("mine") == added
        definition, image = sorted(files(user_folder), key=lambda file: file[-4:], reverse=True)
        assert definition == "robots/mine/robot.toml"
        assert image in ("robots/mine/robot.png", "robots/mine/robot-2.png")


def test_what_is_saved_is_loaded_and_other_files_stay(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    for name in ('a"b = 1', "\\", "größe", "'''", "x" * 40):
        save_robot(str(tmp_path), replace(load_robot("lab"), name=name, maximum_blobs=3))
        assert load_robot(tmp_path).name == name
        assert load_robot(tmp_path).marker_layout().maximum_blobs == 3
    assert files(tmp_path) == ["notes.txt", "robot.png", "robot.toml"]


# --- rotating and removing


def test_rotate_adds_to_the_alignment_and_keeps_what_was_written_by_hand(user_folder):
    add_robot("mine", "lab", alignment=0)
    file = user_folder / "robots/mine/robot.toml"
    before = file.read_text() + "# my note\n"
    file.write_text(before)
    for degrees, after in ((90, 90), (-90, 0), (120, 120), (90, -150), (720.5, -149.5)):
        assert rotate_robot("MINE", degrees).alignment == after
        assert load_robot("mine").alignment == after
    assert "alignment = -149.5" in file.read_text()
    assert file.read_text().endswith("# my note\n")
    with pytest.raises(ValueError, match="degrees"):
        rotate_robot("mine", np.nan)


def test_remove(user_folder):
    for name in ("none", "", "..", "\0"):
        for change in (remove_robot, lambda name: rotate_robot(name, 5)):
            with pytest.raises(ValueError, match="; you have no robots yet"):
                change(name)
    add_robot("mine", "lab")
    with pytest.raises(ValueError, match="; known: mine"):
        remove_robot("../robots")
    add_robot("other", "lab")
    set_default_robot("mine")
    remove_robot("other")
    assert default_robot() == "mine"
    (user_folder / "robots/mine/robot.toml").write_text("oops")
    remove_robot("Mine")  # though it is damaged
    assert robot_names() == SHIPPED
    assert default_robot() == "lab"
    assert files(user_folder) == ["settings.toml"]


# --- the choice


def test_what_is_not_chosen(user_folder):
    for name in ("none", "", "..", "/"):
        with pytest.raises(ValueError, match=r"; known: lab, robot2, sheep"):
            set_default_robot(name)
    assert not user_folder.exists()
    add_robot("mine", "lab")
    (user_folder / "robots/mine/robot.png").unlink()
    with pytest.raises(ValueError, match=r"robot definition .*mine"):
        set_default_robot("mine")
    assert default_robot() == "lab"


def test_other_settings_are_kept(user_folder):
    user_folder.mkdir()
    settings = user_folder / "settings.toml"
    settings.write_text("# mine\nlanguage = 'en'  # a note\n\n[window]\nrobot = 'other'\n")
    assert default_robot() == "lab"
    set_default_robot("sheep")
    values = tomllib.loads(settings.read_text())
    assert values == {"language": "en", "robot": "sheep", "window": {"robot": "other"}}
    assert "# a note" in settings.read_text()
    reset_default_robot()
    assert tomllib.loads(settings.read_text())["window"] == {"robot": "other"}


@pytest.mark.parametrize("content", [b"oops", b"robot = 5", None])
def test_damaged_settings(user_folder, content):
    settings = user_folder / "settings.toml"
    if content is None:
        settings.mkdir(parents=True)
    else:
        user_folder.mkdir()
        settings.write_bytes(content)
    for attempt in (default_robot, load_robot, Simulation):
        with pytest.raises(ValueError, match=r"settings\.toml.*robsim robots reset"):
            attempt()
    if content != b"robot = 5":
        with pytest.raises(ValueError, match="robsim robots reset"):
            set_default_robot("sheep")
    reset_default_robot()
    if content == b"oops":
        (aside,) = user_folder.glob("settings-damaged-*.toml")
        assert aside.read_bytes() == content
    set_default_robot("sheep")
    assert default_robot() == "sheep"


def test_a_chosen_robot_that_is_gone_or_a_path(user_folder, tmp_path):
    add_robot("mine", "lab")
    set_default_robot("mine")
    shutil.rmtree(user_folder / "robots/mine")
    for attempt in (load_robot, Simulation):
        with pytest.raises(ValueError, match=r"settings\.toml: .*'mine', no longer exists"):
            attempt()
    # Settings name robots; they do not load from anywhere.
    save_robot(tmp_path / "elsewhere", load_robot("lab"))
    (user_folder / "settings.toml").write_text(f"robot = '{tmp_path}/elsewhere'")
    with pytest.raises(ValueError, match="no longer exists"):
        load_robot()


def test_strange_things_in_the_user_folder(user_folder):
    add_robot("mine", "lab", size=50)
    robots_folder = user_folder / "robots"
    (robots_folder / "mine").rename(robots_folder / "Sheep")
    assert load_robot("Sheep").size != 50  # a shipped one comes first
    (robots_folder / ".mine.0123").mkdir(parents=True)
    (robots_folder / ".mine.0123/robot.toml").write_text("")
    (robots_folder / "empty").mkdir()
    (robots_folder / "file").write_text("")
    assert robot_names() == SHIPPED


# --- the whole way


@pytest.mark.parametrize("seed", range(thorough(4, 1)))
def test_a_robot_made_up_on_the_spot(seed, tmp_path):
    """Drawn, added as a mere picture, used, tracked by its own markers only, removed."""
    drawn = random_robot(np.random.default_rng(seed))
    Image.fromarray(drawn.image).save(tmp_path / "drawn.png")
    add_robot("drawn", tmp_path / "drawn.png", size=drawn.size)
    rotate_robot("drawn", drawn.alignment)
    set_default_robot("drawn")
    assert load_robot().marker_layout().distance == pytest.approx(
        drawn.marker_layout().distance, abs=0.3
    )
    options = {"area": (600, 600), "headings": None, "measure": True, "seed": seed}
    trace = Simulation(control=DriveAround(), **options).run(120)
    assert trace.info.robot == "drawn"
    statistics = trace.tracking()
    assert statistics.seen > 100
    assert statistics.false_poses == 0
    assert statistics.rmse_xy < 1
    assert statistics.rmse_heading_deg < 2
    for markers in ("lab", MarkerLayout(43, 14)):
        other = Simulation(control=DriveAround(), markers=markers, **options).run(60)
        assert not other.seen.any()
    remove_robot("drawn")
    assert load_robot().name == "lab"
