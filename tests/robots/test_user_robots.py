"""A user's own robots, and the robot in use."""

import os
import shutil
import subprocess
import sys
import tomllib
import unicodedata
from dataclasses import replace
from pathlib import Path

import numpy as np
import platformdirs
import pytest
from PIL import Image

from drawn_robots import box, painted, random_robot
from robsim import DriveAround, Simulation
from robsim.robots import (
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
from robsim.robots._default_robot import data_folder
from robsim.vision import MarkerLayout
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


def test_the_user_folder(user_folder, monkeypatch):
    assert data_folder() == user_folder
    monkeypatch.setenv("ROBSIM_DATA", "~/here")
    assert data_folder() == Path.home() / "here"
    monkeypatch.setenv("ROBSIM_DATA", "")
    assert data_folder() == platformdirs.user_data_path("robsim")


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
        for role, polygon in drawn.markers.items():
            np.testing.assert_allclose(robot.markers[role], polygon, atol=0.0051)


def test_given_values_override_those_of_the_source(photo):
    robot = add_robot("mine", "lab", size=90, alignment=-90, centre=(240, 250),
                      markers={"red": RED, "blue": BLUE},
                      outline=box(5, 5, 470, 470), ignore_colors=True)  # fmt: skip
    assert (robot.name, robot.size, robot.alignment) == ("mine", 90, -90)
    np.testing.assert_array_equal(robot.centre, (240, 250))
    np.testing.assert_array_equal(robot.markers["left"], RED)
    np.testing.assert_array_equal(robot.outline, box(5, 5, 470, 470))
    assert add_robot("other", photo, size=90).size == 90


@pytest.mark.filterwarnings("ignore:the image has no transparency")
def test_any_kind_of_picture(tmp_path):
    image = Image.fromarray(painted(RED, BLUE)).convert("RGB")
    for kind in ("jpg", "bmp", "gif", "webp"):
        image.save(tmp_path / f"photo.{kind}")
        robot = add_robot(kind, tmp_path / f"photo.{kind}")
        assert robot.marker_layout().distance == pytest.approx(48, abs=0.2)
        assert robot.image.shape == (400, 400, 4)
    image.convert("L").save(tmp_path / "grey.png")
    markers = {"red": RED, "blue": BLUE}
    grey = add_robot("grey", tmp_path / "grey.png", markers=markers, ignore_colors=True)
    assert grey.image.shape == (400, 400, 4)


def test_a_large_robot_is_scaled_down():
    lab = load_robot("lab")
    image = np.repeat(np.repeat(lab.image, 3, axis=0), 3, axis=1)[:, 60:-60]  # high
    moved = 1 - np.array((60, 0))
    points = {name: 3 * getattr(lab, name) + moved for name in ("centre", "outline")}
    points["markers"] = {role: 3 * polygon + moved for role, polygon in lab.markers.items()}
    robot = add_robot("mine", replace(lab, image=image, size=120 * 1320 / 1440, **points))
    assert max(robot.image.shape) == 1000
    assert robot.marker_layout().distance == pytest.approx(43, abs=0.05)
    assert robot.marker_layout().offset == pytest.approx(14, abs=0.05)


def test_a_robot_is_replaced_only_when_asked_whatever_the_case(user_folder):
    add_robot("Mine", "lab")
    assert load_robot("mINE").name == "Mine"
    with pytest.raises(ValueError, match=r"'Mine' already.*overwrite=True"):
        add_robot("mine", "lab", size=60)
    assert load_robot("mine").size == 120
    add_robot("MINE", "Mine", size=60, overwrite=True)
    assert load_robot("mine").size == 60
    assert robot_names() == [*SHIPPED, "MINE"]
    assert files(user_folder) == ["robots/MINE/robot.png", "robots/MINE/robot.toml"]
    set_default_robot("mine")
    assert default_robot() == "MINE"


@pytest.mark.parametrize("name", ["größe-2", "लैब"])
def test_names_of_all_languages(name):
    add_robot(name, "lab")
    set_default_robot(name.upper())
    assert default_robot() == name
    # An accent may be a character of its own.
    assert load_robot(unicodedata.normalize("NFD", name)).name == name
    with pytest.raises(ValueError, match="already"):
        add_robot(unicodedata.normalize("NFD", name), "lab")


def test_names_that_are_refused(user_folder):
    plain = ["", " ", "..", "a/b", "a\\b", "C:x", "a.b", "-a", "_a", "x" * 41, "\0", "a\n", "a*"]
    for name in (*plain, "½", "\u0308a", "con", "NUL", "com1", "Lpt9", "aux", "prn"):
        with pytest.raises(ValueError, match="name must"):
            add_robot(name, "lab")
    assert not user_folder.exists()


def test_names_that_are_taken():
    for name in ("0", "x" * 40, "A-b_9", "com10"):
        assert add_robot(name, "lab").name == name


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


def test_sources_that_are_none(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.png").write_text("hello")
    for source, said in (
        ("no such", r"\bsource\b.*lab, robot2, sheep"),
        (tmp_path / "none.png", r"\bsource\b"),
        (tmp_path / "empty", r"empty has no robot\.toml"),
        (tmp_path / "text.png", r"text\.png"),
    ):
        with pytest.raises(ValueError, match=said):
            add_robot("mine", source)


def test_colours_that_are_not_seen(user_folder, photo, tmp_path):
    colors = tmp_path / "colors.toml"
    colors.write_text("[red]\nv = [250, 255]\n[blue]\nu = [160, 255]\nv = [0, 140]\n")
    with pytest.raises(ValueError, match=r"right marker \(red\): 0.0 % .*ignore_colors=True"):
        add_robot("mine", "lab", colors=colors)
    with pytest.raises(ValueError, match="red marker: nothing"):
        add_robot("mine", photo, colors=colors)
    assert not user_folder.exists()
    assert add_robot("mine", "lab", colors=colors, ignore_colors=True).name == "mine"


# --- all or nothing


def broken(*arguments, **options):
    raise OSError("the disk is full")


@pytest.mark.parametrize(
    "step", ["robsim.robots._files.write_whole", "robsim.robots._user_robots.read_robot", "rename"]
)
def test_a_failing_add_leaves_nothing_behind(user_folder, monkeypatch, step):
    lab = load_robot("lab")
    if step == "rename":
        monkeypatch.setattr(Path, "rename", broken)
    else:
        monkeypatch.setattr(step, broken)
    with pytest.raises(OSError, match="the disk is full"):
        add_robot("mine", lab)
    assert files(user_folder) == []
    assert robot_names() == SHIPPED


@pytest.mark.parametrize("failing", [1, 2])
def test_a_failing_overwrite_leaves_the_old_one(user_folder, monkeypatch, failing):
    """The first file is the new image, the second one the definition that names it."""
    add_robot("mine", "lab", size=77)
    replace_file, calls = os.replace, []

    def fail_once(path, target):
        if "robots/mine/" in str(target):
            calls.append(target)
            if len(calls) == failing:
                broken()
        return replace_file(path, target)

    monkeypatch.setattr(os, "replace", fail_once)
    with pytest.raises(OSError, match="the disk is full"):
        add_robot("mine", "sheep", overwrite=True)
    assert load_robot("mine") == replace(load_robot("lab"), name="mine", size=77.0)


def test_an_overwrite_leaves_one_image(user_folder):
    for source in ("lab", "sheep", "sheep"):
        added = add_robot("mine", source, overwrite=True)
        assert load_robot("mine") == added
        definition, image = sorted(files(user_folder), key=lambda file: file[-4:], reverse=True)
        assert definition == "robots/mine/robot.toml"
        assert image in ("robots/mine/robot.png", "robots/mine/robot-2.png")


def test_a_failing_save_leaves_the_old_file(tmp_path, monkeypatch):
    save_robot(tmp_path, load_robot("lab"))
    before = {file: (tmp_path / file).read_bytes() for file in files(tmp_path)}
    monkeypatch.setattr(os, "replace", broken)
    with pytest.raises(OSError, match="the disk is full"):
        save_robot(tmp_path, load_robot("sheep"))
    assert {file: (tmp_path / file).read_bytes() for file in files(tmp_path)} == before


# --- files


def test_a_saved_robot_can_be_read_by_people(tmp_path):
    save_robot(tmp_path / "a/b", load_robot("lab"))
    text = (tmp_path / "a/b/robot.toml").read_text()
    assert "alignment = 90.0   # degrees clockwise" in text
    assert "centre = [239.50, 239.50]\n" in text
    assert "\n    [239.50, 26.47], [308.40, 32.50], [312.53, 33.61], [314.37, 34.47],\n" in text
    assert max(map(len, text.splitlines())) <= 100


def test_any_name_is_saved(tmp_path):
    for name in ('a"b = 1', "\\", "größe", "'''", "x" * 40):
        save_robot(tmp_path, replace(load_robot("lab"), name=name))
        assert load_robot(tmp_path).name == name


def test_a_name_that_cannot_be_shown():
    for name in ("", "a\nb = 1", "\x1b]0;mine\a", "\u202eenim", "a\0b", 41 * "a"):
        with pytest.raises(ValueError, match="name must be 1 to 40") as told:
            replace(load_robot("lab"), name=name)
        assert str(told.value).isprintable()


def test_other_files_of_the_folder_are_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    save_robot(tmp_path, load_robot("lab"))
    save_robot(str(tmp_path), load_robot("lab"))
    assert files(tmp_path) == ["notes.txt", "robot.png", "robot.toml"]


# --- rotating


def test_rotate_adds_to_the_alignment():
    add_robot("mine", "lab", alignment=0)
    for degrees, after in ((90, 90), (-90, 0), (120, 120), (90, -150), (720.5, -149.5)):
        assert rotate_robot("MINE", degrees).alignment == after
        assert load_robot("mine").alignment == after
    with pytest.raises(ValueError, match="degrees"):
        rotate_robot("mine", np.nan)


def test_rotate_keeps_what_was_written_by_hand(user_folder):
    add_robot("mine", "lab")
    file = user_folder / "robots/mine/robot.toml"
    before = file.read_text() + "# my note\n"
    file.write_text(before)
    rotate_robot("mine", 45)
    assert file.read_text() == before.replace("alignment = 90.0", "alignment = 135.0")


# --- removing


def test_remove(user_folder):
    add_robot("mine", "lab")
    add_robot("other", "lab")
    set_default_robot("mine")
    remove_robot("other")
    assert default_robot() == "mine"
    remove_robot("Mine")
    assert robot_names() == SHIPPED
    assert default_robot() == "lab"
    assert files(user_folder) == ["settings.toml"]


def test_a_damaged_robot_and_damaged_settings_do_not_keep_one_from_removing(user_folder):
    add_robot("mine", "lab")
    (user_folder / "robots/mine/robot.toml").write_text("oops")
    (user_folder / "settings.toml").write_text("oops")
    assert "mine" in robot_names()
    remove_robot("mine")
    assert robot_names() == SHIPPED


def test_there_is_nothing_of_this_name():
    for name in ("none", "", "..", "/", "\0"):
        with pytest.raises(ValueError, match="of your own: there is none yet"):
            remove_robot(name)
        with pytest.raises(ValueError, match="of your own: there is none yet"):
            rotate_robot(name, 5)
    add_robot("mine", "lab")
    with pytest.raises(ValueError, match="of your own: there are mine"):
        remove_robot("../robots")
    assert robot_names()[-1] == "mine"


# --- the choice


def test_the_choice_survives_a_restart(user_folder):
    add_robot("mine", "lab")
    set_default_robot("mine")
    run = "import robsim.robots; print(robsim.robots.load_robot().name)"
    result = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, check=True)
    assert result.stdout == "mine\n"
    assert (user_folder / "settings.toml").exists()


def test_a_robot_that_is_none_is_not_chosen(user_folder):
    for name in ("none", "", "..", "/"):
        with pytest.raises(ValueError, match=r"there are lab, robot2, sheep"):
            set_default_robot(name)
    assert not user_folder.exists()


def test_a_damaged_robot_is_not_chosen(user_folder):
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
    assert "# mine" in settings.read_text()
    assert "# a note" in settings.read_text()
    reset_default_robot()
    assert tomllib.loads(settings.read_text())["window"] == {"robot": "other"}
    assert default_robot() == "lab"


@pytest.mark.parametrize("content", [b"oops", b"robot = 5", b"\xff\xfe"])
def test_damaged_settings(user_folder, content):
    user_folder.mkdir()
    settings = user_folder / "settings.toml"
    settings.write_bytes(content)
    for attempt in (default_robot, load_robot, Simulation):
        with pytest.raises(ValueError, match=r"settings\.toml.*robsim robots reset"):
            attempt()
    if content != b"robot = 5":
        with pytest.raises(ValueError, match="robsim robots reset"):
            set_default_robot("sheep")
    reset_default_robot()
    aside = [file.read_bytes() for file in user_folder.glob("settings-damaged-*.toml")]
    assert aside == ([] if content == b"robot = 5" else [content])
    assert default_robot() == "lab"
    set_default_robot("sheep")
    assert default_robot() == "sheep"


def test_settings_that_are_a_folder(user_folder):
    (user_folder / "settings.toml").mkdir(parents=True)
    for attempt in (default_robot, lambda: set_default_robot("sheep")):
        with pytest.raises(ValueError, match=r"settings\.toml.*robsim robots reset"):
            attempt()
    reset_default_robot()
    assert default_robot() == "lab"


def test_a_chosen_robot_that_is_gone(user_folder):
    add_robot("mine", "lab")
    set_default_robot("mine")
    shutil.rmtree(user_folder / "robots/mine")
    for attempt in (load_robot, Simulation):
        with pytest.raises(ValueError, match=r"settings\.toml: .*'mine', no longer exists"):
            attempt()
    assert default_robot() == "mine"
    reset_default_robot()
    assert load_robot().name == "lab"


def test_a_chosen_robot_that_is_a_path(user_folder, tmp_path):
    """Settings name robots; they do not load from anywhere."""
    save_robot(tmp_path / "elsewhere", load_robot("lab"))
    user_folder.mkdir()
    (user_folder / "settings.toml").write_text(f"robot = '{tmp_path}/elsewhere'")
    with pytest.raises(ValueError, match="no longer exists"):
        load_robot()


def test_a_shipped_robot_comes_before_an_own_one_of_its_name(user_folder):
    add_robot("mine", "lab", size=50)
    (user_folder / "robots/mine").rename(user_folder / "robots/Sheep")
    assert load_robot("Sheep").size != 50
    assert robot_names() == SHIPPED
    remove_robot("Sheep")
    assert files(user_folder) == []


def test_strange_things_in_the_user_folder(user_folder):
    robots_folder = user_folder / "robots"
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


def test_the_number_of_blobs_is_kept(tmp_path):
    save_robot(tmp_path, replace(load_robot("lab"), maximum_blobs=3))
    assert load_robot(tmp_path).marker_layout().maximum_blobs == 3
