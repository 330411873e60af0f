"""The commands ``robsim robots``."""

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from commands import cli
from drawn_robots import box, painted, random_robot
from robsim.cli import app
from robsim.vision import (
    add_robot,
    default_robot,
    load_robot,
    robot_names,
    save_robot,
    set_default_robot,
)

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("user_folder", "_here")]

RED, BLUE = box(240, 240, 319, 319), box(80, 240, 159, 319)


@pytest.fixture
def _here(tmp_path, monkeypatch):
    """Commands run in an empty folder."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


@pytest.fixture
def photo(_here):
    """A picture's file in the folder."""
    Image.fromarray(painted(RED, BLUE)).save("photo.png")


def robots(*arguments):
    """Run ``robsim robots`` in this process, in a terminal of 80 columns."""
    return CliRunner(env={"COLUMNS": "80"}).invoke(app, ["robots", *map(str, arguments)])


def done(*arguments):
    result = robots(*arguments)
    assert result.exit_code == 0, result.output
    return result.stdout


def refused(*arguments):
    """What a command says that ends with status 2, in one line."""
    result = robots(*arguments)
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    return result.stderr


def rows(text):
    """The rows of the table by the robot's name."""
    lines = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]
    return {line[0]: line[1:] for line in lines if len(line) > 1}


def test_list():
    table = rows(done("list"))
    assert list(table) == ["robot", "lab", "robot2", "sheep"]
    assert table["lab"] == ["120 px", "90°, faces up", "43.0 px", "shipped", "in use"]
    name = "x" * 40
    add_robot(name, "lab", alignment=-123.456)
    set_default_robot(name)
    lines = done("list").splitlines()
    assert rows("\n".join(lines))["lab"][-1] == "shipped"
    assert max(map(len, lines)) <= 80
    assert "".join(line.split()[0] for line in lines if line.strip().startswith("x")) == name


def test_a_damaged_robot_is_listed_with_its_error(user_folder):
    add_robot("bad", "lab")
    (user_folder / "robots/bad/robot.toml").write_text("size = ")
    result = robots("list")
    assert result.exit_code == 0
    assert rows(result.stdout)["bad"] == ["damaged", "yours"]
    assert "bad/robot.toml" in result.stderr


def test_list_says_what_is_wrong_with_the_choice(user_folder):
    add_robot("mine", "lab")
    set_default_robot("mine")
    (user_folder / "robots/mine").rename(user_folder / "robots/sheep")
    result = robots("list")
    assert "in use" not in result.stdout
    assert "'mine'" in result.stderr
    assert "precedence" in result.stderr  # of the one that ships
    (user_folder / "settings.toml").write_text("oops")
    assert "settings.toml" in robots("list").stderr


def test_show():
    text = done("show", "lab")
    for number in ("480 x 480 px", "120 px", "90°", "(239.5, 239.5)", "43.0 px", "531 px"):
        assert number in text
    with Image.open("robot-lab.png") as picture:
        assert min(picture.size) > 500


def test_show_writes_where_it_says():
    assert str(Path("b/c.pdf")) in done("show", "lab", "--out", "b/c.pdf")
    assert Path("b/c.pdf").read_bytes().startswith(b"%PDF")
    assert "none" in refused("show", "none")
    assert "xyz" in refused("show", "lab", "--out", "a.xyz")
    assert "c.pdf" in refused("show", "lab", "--out", "b/c.pdf/a.png")


@pytest.mark.usefixtures("undrawn")
def test_show_of_a_folder_says_what_is_wrong(tmp_path):
    save_robot(tmp_path / "folder", load_robot("lab"))
    done("show", tmp_path / "folder")
    assert Path("robot-lab.png").is_file()
    file = tmp_path / "folder/robot.toml"
    text = file.read_text().replace("size = 120.0", "size = 10")
    file.write_text(text.replace('name = "lab"', 'name = "../../a b"'))
    result = robots("show", tmp_path / "folder")
    assert result.exit_code == 0
    assert Path("robot--a-b.png").is_file()
    assert result.stderr.count("error: ") == 2  # markers too small to be detected
    file.write_text(text.replace("centre = [239.5", "centre = [1.0"))
    assert "centre" in refused("show", tmp_path / "folder")


def test_an_opaque_picture_is_told():
    opaque = painted(RED, BLUE)
    opaque[..., 3] = 255
    Image.fromarray(opaque).save("opaque.png")
    with pytest.warns(UserWarning, match="transparent"):
        done("add", "mine", "opaque.png")
    done("add", "other", "opaque.png", "--outline", "9,9 390,9 390,390 9,390")


@pytest.mark.usefixtures("photo")
def test_add_with_all_options(tmp_path):
    (tmp_path / "colors.toml").write_text("[red]\n[blue]\n")
    red, blue = "red=240,240 319.5,240 319,319 240,319", "blue=80,240  160,240\n160,320"
    points = "--marker", red, "--marker", blue
    edge = "--outline", "-0.5,-0.5 399,-0.5 399,399 -0.5,399", "--centre", "190,210"
    colors = "--colors", tmp_path / "colors.toml", "--anyway"
    size = "--size", "100", "--alignment", "-90"
    text = done("add", "mine", "photo.png", *points, *edge, *colors, *size)
    assert "400 x 400 px" in text
    assert "-90°, faces down" in text
    robot = load_robot("mine")
    assert (robot.size, robot.alignment) == (100, -90)
    np.testing.assert_array_equal(
        robot.markers["left"].polygon, [(240, 240), (319.5, 240), (319, 319), (240, 319)]
    )
    np.testing.assert_array_equal(
        robot.markers["right"].polygon, [(80, 240), (160, 240), (160, 320)]
    )
    np.testing.assert_array_equal(robot.outline[0], (-0.5, -0.5))
    np.testing.assert_array_equal(robot.centre, (190, 210))


def test_add_from_a_robot():
    done("add", "mine", "lab", "--size", "60")
    assert load_robot("mine").size == 60
    assert "or --overwrite in the shell" in refused("add", "mine", "lab")
    done("add", "mine", "lab", "--overwrite")
    assert load_robot("mine").size == 120


def test_add_refuses_and_leaves_nothing_behind(user_folder):
    Path("text.png").write_text("hello")
    Image.new("L", (30, 30), 99).save("grey.png")
    for named, *arguments in [
        ("ships with robsim", "lab", "sheep"),
        ("NAME", "../x", "lab"),
        ("text.png", "mine", "text.png"),
        ("--marker", "mine", "lab", "--marker", "red=hello"),
        ("--marker", "mine", "lab", "--marker", "1,2 3,4 5,9"),
        ("--marker['red'] must", "mine", "lab", "--marker", "red=nan,1 2,2 3,1"),
        ("--outline", "mine", "lab", "--outline", "1 2 3"),
        ("--centre", "mine", "lab", "--centre", "1,2 3,4"),
        ("(red) and back marker", "mine", "lab", "--marker", "red=120,260 190,260 150,330"),
        ("0.0 %", "mine", "lab", "--marker", "red=230,100 250,100 240,120"),
        ("too small", "mine", "lab", "--size", "12"),
        ("red marker", "mine", "grey.png"),
    ]:
        assert named in refused("add", *arguments), arguments
        assert not user_folder.exists()


def test_rotate():
    done("add", "mine", "lab")
    assert "180°, faces left" in done("rotate", "mine", "90")
    assert "134.5°\n" in done("rotate", "mine", "-45.5")
    assert load_robot("mine").alignment == 134.5
    assert "DEGREES must" in refused("rotate", "mine", "inf")
    assert "ships with robsim" in refused("rotate", "lab", "-90")


def test_use_reset_remove():
    assert done("use", "SHEEP") == "in use: sheep\n"
    assert default_robot() == "sheep"
    assert done("show").startswith("sheep: ")
    assert done("reset") == "in use: lab\n"
    done("add", "mine", "lab")
    done("use", "mine")
    assert done("remove", "mine") == "mine is removed; in use: lab\n"
    assert "mine" not in robot_names()


def test_use_and_remove_refuse():
    for name in ("none", "", "..", "/etc"):
        assert repr(name) in refused("use", name)
        refused("remove", name)
    for name in ("lab", "sheep", "Lab"):
        assert "ships with robsim" in refused("remove", name)
    assert robot_names() == ["lab", "robot2", "sheep"]


def test_reset_always_works(user_folder):
    user_folder.mkdir()
    (user_folder / "settings.toml").write_text("oops")
    assert "reset" in refused("show")
    assert done("reset") == "in use: lab\n"
    assert done("show").startswith("lab: ")


@pytest.mark.slow
def test_a_drawn_robot_on_the_whole_way(rng):
    """In several processes: the choice survives."""
    drawn = random_robot(rng)
    Image.fromarray(drawn.image).save("drawn.png")
    done("add", "drawn", "drawn.png", "--size", drawn.size)
    assert cli("robots", "use", "drawn").returncode == 0
    assert cli("robots", "show").stdout.startswith("drawn: image of 400 x 400 px")
    assert Path("robot-drawn.png").is_file()
    assert done("remove", "drawn") == "drawn is removed; in use: lab\n"


def test_a_robot_of_other_colours_is_added_and_shown():
    paints = (30, 150, 60, 255), (245, 130, 20, 255)
    Image.fromarray(painted(RED, BLUE, paints=paints)).save("photo.png")
    Path("colors.toml").write_text(
        "[green]\nu = [0, 116]\nv = [0, 104]\n[orange]\nu = [0, 92]\nv = [154, 255]\n"
    )
    refused("add", "fruit", "photo.png", "--colors", "colors.toml")
    options = "--colors", "colors.toml", "--marker-colors", "green,orange"
    said = done("add", "fruit", "photo.png", *options)
    assert re.search("front +green, 576 px.*\n +back +orange, 576 px", said)
    assert load_robot("fruit").marker_layout().colors == {"front": "green", "back": "orange"}
    assert "green, 576" in done("show", "fruit", "--colors", "colors.toml")
    refused("add", "other", "photo.png", *options[:2], "--marker-colors", "green")
