"""The commands ``robsim colors``."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import robsim
from robsim import ColorClass, load_colors
from robsim.cli import app
from robsim.vision import colors_to_toml, load_image, save_colors, score_color

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("user_folder", "_here")]

RED, BLUE, FLOOR = (198, 36, 40), (30, 60, 220), (150, 148, 146)
REGION = (30, 40, 49, 59)


@pytest.fixture
def _here(tmp_path, monkeypatch):
    """Commands run in an empty folder."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


def colors(*arguments):
    """Run ``robsim colors`` in this process, in a terminal of 80 columns."""
    return CliRunner(env={"COLUMNS": "80"}).invoke(app, ["colors", *map(str, arguments)])


def done(*arguments):
    result = colors(*arguments)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout


def refused(*arguments):
    """What a command says that ends with status 2."""
    result = colors(*arguments)
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    return result.stderr


def rows(text):
    """The rows of a table by their first two cells."""
    lines = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]
    return {tuple(line[:2]): line[2:] for line in lines if len(line) > 1}


def picture(name, *, rgb=RED, light=1.0):
    image = np.full((100, 120, 3), FLOOR, np.uint8)
    image[40:60, 30:50] = rgb
    Image.fromarray(np.rint(image * light).astype(np.uint8)).save(name)
    return Path(name)


def test_frame_says_where_the_markers_are():
    _, *lines = done("frame", "--robot", "lab", "--at", "300,400", "--heading", "45").splitlines()
    image = load_image("frame.png")
    assert image.shape == (1200, 1200, 3)
    blobs = robsim.find_blobs(image, load_colors())
    masks = robsim.vision.classify(image, load_colors())
    for line, marker, name in zip(lines, ("right", "left"), ("red", "blue"), strict=True):
        assert f"{marker} marker ({name})" in line
        left, top, right, bottom = map(int, line.split()[-1].split(","))
        (blob,) = blobs[name]
        assert abs(blob.centroid - ((left + right) / 2, (top + bottom) / 2)).max() < 1
        assert masks[name][top : bottom + 1, left : right + 1].all()


def test_frame_refuses():
    for named, arguments in [
        ("none", ("--robot", "none")),
        ("--at", ("--at", "-500,0")),
        ("--noise", ("--noise", "white")),
        ("xyz", ("frame.xyz",)),
    ]:
        assert named in refused("frame", *arguments)


def test_list_shows_the_limits_of_each_colour():
    text = done("list")
    for color in load_colors():
        (line,) = (line for line in text.splitlines() if line.split()[:1] == [color.name])
        for low, high in (color.u, color.v):
            assert f"{low} .. {high}" in line
    save_colors("mine.toml", [ColorClass("green dark", y=(0, 90)), ColorClass("x")])
    text = done("list", "mine.toml")
    assert "green dark   0 .. 90   any" in text
    assert "from mine.toml" in text
    Path("bad.toml").write_text("[red]\nu = [1]")
    assert "bad.toml, line 2: [red] u" in refused("list", "bad.toml")


def test_train_prints_what_it_finds():
    picture("a.png")
    picture("dark.png", light=0.5)
    region = "--region", "30,40,49,59"
    train = ("train", "a.png", *region, "--name", "red")
    color = ColorClass.from_region(load_image("a.png"), REGION, name="red")
    assert done(*train) == colors_to_toml(color) + "\n"
    assert len([*Path().iterdir()]) == 2  # no file of colours
    assert "v = [208, 255]" in done(*train, "--margin", 0)
    assert "y = [32, 136]" in done(*train, "--limit-y")
    # V is 168 in the dark one
    both = ("train", "a.png", "dark.png", *region, *region, "--name", "red", "--margin", 0)
    assert "v = [168, 255]" in done(*both)


def test_train_writes_a_file_and_a_figure():
    picture("a.png")
    picture("b.png", rgb=BLUE)
    region = "--region", "30,40,49,59"
    to = "--to", "x/c.toml"
    done("train", "a.png", *region, "--name", "red", *to, "--figure", "y/h.png")
    with Image.open("y/h.png") as figure:
        assert min(figure.size) > 200
    done("train", "b.png", *region, "--name", "blue", *to)
    red, blue = load_colors("x/c.toml")
    assert (red.name, blue.name) == ("red", "blue")
    blobs = robsim.find_blobs(load_image("b.png"), [red, blue])
    assert [len(blobs[name]) for name in ("red", "blue")] == [0, 1]


def test_train_refuses_and_writes_nothing():
    picture("a.png")
    save_colors("c.toml", ColorClass("green"))
    Path("bad.toml").write_text("oops")
    before = sorted((path.name, path.read_bytes()) for path in Path().iterdir())
    for named, arguments in [
        ("region", ("a.png", "--region", "0,0,9,9")),
        ("--region", ("a.png", "--region", "0,0,9," + "9" * 5000)),
        ("120 x 100 px", ("a.png", "--region", "30,40,49,100")),
        ("2 images", ("a.png", "a.png", "--region", "30,40,49,59")),
        ("xyz", ("a.png", "--region", "30,40,49,59", "--figure", "h.xyz")),
        ("bad.toml", ("a.png", "--region", "30,40,49,59", "--to", "bad.toml")),
        ("a.png", ("a.png", "--region", "30,40,49,59", "--to", "a.png/c.toml")),
    ]:
        where = () if "--to" in arguments else ("--to", "c.toml")
        assert named in refused("train", *arguments, "--name", "red", *where)
        assert sorted((path.name, path.read_bytes()) for path in Path().iterdir()) == before


def test_test_counts_blobs_and_paints():
    picture("a.png")
    picture("b.png", rgb=BLUE)
    table = rows(done("test", "a.png", "b.png", "--smoothing", 1, "--out", "seen"))
    assert table["a.png", "red"] == ["400", "1", "400 px", "(39.5, 49.5)"]
    assert table["a.png", "blue"] == ["0", "0"]
    assert table["b.png", "blue"][0] == "400"
    painted = load_image("seen/a.png")
    assert painted.shape == (100, 120, 3)
    assert painted[50, 40].tolist() == [255, 0, 0]
    assert load_image("seen/b.png")[50, 40].tolist() == [0, 0, 255]
    result = json.loads(done("test", "a.png", "--json", "--smoothing", 1, "--out", "seen.png"))
    assert result["scores"] == []
    assert result["found"]["a.png"]["red"] == {
        "pixels": 400,
        "blobs": [{"area": 400, "centroid": [39.5, 49.5], "bounding_box": [30, 40, 49, 59]}],
    }


def test_test_scores_a_colour():
    picture("a.png")
    weak = ColorClass("red", v=(170, 255))
    save_colors("weak.toml", [weak, ColorClass("blue", u=(156, 255))])
    arguments = "test", "a.png", "--colors", "weak.toml", "--region", "red=30,40,49,59"
    score = score_color(load_image("a.png"), weak, [REGION])
    text = done(*arguments)
    assert str(score) in text
    assert colors_to_toml(score.proposed) in text
    result = json.loads(done(*arguments, "--json"))
    assert result["scores"] == [json.loads(json.dumps(score.to_dict()))]


def test_test_refuses():
    Path("b").mkdir()
    for name in ("a.png", "b/a.png", "b/c.png"):
        picture(name)
    for named, arguments in [
        ("none.toml", ("a.png", "--colors", "none.toml")),
        ("smoothing", ("a.png", "--smoothing", "4")),
        ("--region", ("a.png", "--region", "green=30,40,49,59")),
        ("--region", ("a.png", "a.png", "--region", "red=30,40,49,59")),
        ("overwrite a.png", ("a.png", "--out", "a.png")),
        ("names", ("a.png", "b/a.png", "--out", "seen")),
        ("overwrite b/c.png", ("a.png", "b/c.png", "--out", "b")),
    ]:
        assert named in refused("test", *arguments)


def recording(folder, exposures=(1, 0.6, 0.3)):
    """A folder of images of the lab robot on its way, in light that fades."""
    for k, exposure in enumerate(exposures):
        sim = robsim.Simulation(robot="lab", start=(300 + 200 * k, 500, 0.4 * k), seed=1)
        save_picture(f"{folder}/{k}.png", (sim.frame.image * exposure).astype(np.uint8))


def save_picture(file, pixels):
    Path(file).parent.mkdir(exist_ok=True)
    Image.fromarray(pixels).save(file)


def test_train_on_a_recording():
    recording("run")
    text = done("train", "run", "--robot", "lab", "--to", "c.toml")
    red, blue = load_colors("c.toml")
    assert (red.name, blue.name) == ("red", "blue")
    assert len(re.findall(r"#\s+frame 2 ", text)) == 2
    for k in range(3):
        blobs = robsim.find_blobs(load_image(f"run/{k}.png"), [red, blue], minimum_area=60)
        assert blobs["red"]
        assert blobs["blue"]


def test_train_on_a_recording_from_regions_in_its_first_frame():
    recording("run", (1, 0.8))
    blobs = robsim.find_blobs(load_image("run/0.png"), load_colors(), minimum_area=200)
    regions = []
    for name in ("red", "blue"):
        u, v = blobs[name][0].centroid.astype(int)
        regions.append(f"--region={name}={u - 5},{v - 5},{u + 5},{v + 5}")
    assert "[blue]" in done("train", "run", "--robot", "lab", *regions)
    assert "blue" in refused("train", "run", "--robot", "lab", regions[0])
    nameless = regions[0].replace("red=", "")
    assert "red=" in refused("train", "run", "--robot", "lab", nameless)


def test_train_on_a_recording_refuses():
    picture("a.png")
    save_picture("run/0.png", np.full((100, 100, 3), 150, np.uint8))
    save_picture("floor/0.png", np.full((100, 100, 3), 150, np.uint8))
    for named, arguments in [
        ("--name", ("a.png",)),
        ("--limit-y", ("run", "--limit-y")),
        ("--figure", ("run", "--figure", "h.png")),
        ("--region", ("a.png", "--name", "red")),
        ("--robot", ("a.png", "--name", "red", "--robot", "lab")),
        ("frame 0", ("floor", "--robot", "lab")),
    ]:
        assert named in refused("train", *arguments, "--to", "c.toml")
        assert not Path("c.toml").exists()


def test_train_on_a_session():
    sims = [robsim.Simulation(robot="lab", start=(300 + 200 * k, 500, k), seed=1) for k in range(2)]
    frames = [robsim.Frame(sim.frame.image, t=0.2 * k) for k, sim in enumerate(sims)]
    robsim.Experiment(frames, robot="lab", record="monday").run()
    assert "[blue]" in done("train", "monday", "--robot", "lab")
    assert "--area" in refused("train", "monday", "--robot", "lab", "--area", "600x600")
