import base64
import contextlib
import inspect
import io
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import robsim
from robsim import Replay, Scenario
from robsim.simulation.scenario_file import TABLES
from robsim.vision import MarkerLayout
from scenarios import FULL, scenarios
from sizes import thorough

pytestmark = pytest.mark.filterwarnings("ignore:a noise of", "ignore:a heading noise of")

# --- there and back


@pytest.mark.long
@settings(max_examples=thorough(100, 12))
@given(scenarios())
def test_a_file_gives_the_scenario_again(scenario):
    text = scenario.to_toml()
    again = Scenario.from_toml(text)
    assert again == scenario
    assert again.to_toml() == text


def test_all_options_at_once(tmp_path):
    FULL.save(tmp_path / "full.toml")
    again = Scenario.load(tmp_path / "full.toml")
    assert again == FULL
    assert np.array_equal(again.robot.image, FULL.robot.image)
    assert np.array_equal(again.background.pixels, FULL.background.pixels)


@pytest.mark.long
@settings(max_examples=25)
@given(st.floats(-1e300, 1e300), st.floats(-1e300, 1e300))
def test_every_bit_of_a_number_is_kept(one, other):
    for control in (robsim.Spin(one), Replay([(one, other)])):
        again = Scenario.from_toml(Scenario(control=control).to_toml()).control
        numbers = [value.hex() for value in np.ravel(getattr(again, "u", one)).tolist()]
        assert again == control
        assert one.hex() in numbers


@pytest.mark.parametrize("kind", [kind for kind in TABLES if kind is not MarkerLayout])
def test_a_table_has_a_key_for_each_argument_of_its_value(kind):
    assert TABLES[kind].keys.keys() == inspect.signature(TABLES[kind].make).parameters.keys()


def test_only_what_is_not_the_default_is_written():
    assert tomllib.loads(Scenario().to_toml()) == {"format": 1, "robot": "lab"}
    scenario = Scenario(area=(300, 200), measure=True, noise=robsim.GaussianNoise(10))
    assert scenario.to_toml().splitlines()[1:] == [
        "format = 1",
        'robot = "lab"',
        "area = [300, 200] # width and height, px",
        "measure = true",
        "",
        "[noise]",
        'kind = "GaussianNoise"',
        "percent = 10 # %",
    ]


def test_the_users_own_default_robot_is_written(user_folder):
    robsim.vision.set_default_robot("sheep")
    assert 'robot = "sheep"' in Scenario().to_toml()


@pytest.mark.long
def test_a_robot_that_another_machine_does_not_have(user_folder, tmp_path):
    robsim.vision.add_robot("mine", robsim.load_robot("robot2"))
    scenario = Scenario(robot="mine")
    scenario.save(tmp_path / "run.toml")
    robsim.vision.remove_robot("mine")
    assert Scenario.load(tmp_path / "run.toml") == scenario


def test_a_file_written_by_hand(tmp_path):
    (tmp_path / "run.toml").write_bytes(
        b"\xef\xbb\xbfarea = [300, 200]\r\n"
        b"markers = { left = { position = [1, 2] }, right = { position = [3, 4] } }\n"
        b"noise.kind = 'UniformNoise'\nnoise.percent = 3\n"
        b"[process_noise]\nkind = 'WheelNoise'\nsigma = 1\n"
        b"[control]\nkind = 'Spin'\n"
        b"[colors.red]\nu = [1, 2]\n"
        b"[dropout]\nprobability = 0.5"
    )
    assert Scenario.load(str(tmp_path / "run.toml")) == Scenario(
        area=(300, 200),
        markers=robsim.vision.MarkerLayout.from_positions({"right": (3, 4), "left": (1, 2)}),
        noise=robsim.UniformNoise(3),
        process_noise=robsim.WheelNoise(1),
        control=robsim.Spin(),
        colors=[robsim.ColorClass("red", u=(1, 2))],
        dropout=robsim.Dropout(0.5),
    )


# --- files from a stranger


def png(mode, size):
    content = io.BytesIO()
    Image.new(mode, size).save(content, format="PNG")
    return base64.b64encode(content.getvalue()).decode()


REFUSED = {
    "areas = [3, 3]": "'areas'.*'area'",
    "area = [1, 2]": "area",
    "boundary = {}": "boundary .*'bounce'",
    "smoothing = true": "smoothing .*got True",
    "measure = 1": "measure .*true or false",
    "start = [1, 2, nan]": "start",
    "start = [300, 300, 90]": "start .*in degrees",
    f"start = [{'9' * 400}, 0, 0]": "",
    "seed = -1": "seed",
    f"seed = 0x{'f' * 900_000}": "4000 digits, got 'seed =",
    f"seed = 0x{'f' * 2000}": "seed .*4096",
    f"seed = {'9' * 5000}": "4000 digits, got 'seed =",
    f"[seed]\nentropy = [1, 0x{'f' * 2000}]": r"\[seed\] entropy .*4096",
    "seed = 1979-05-27T07:32:00Z": "seed .*the time 1979-05-27T",
    "[seed]\nentropy = [1, -1]": r"\[seed\] entropy",
    "[seed]\nentropy = 1\nspawn_key = 'x'": r"\[seed\] spawn_key",
    "robot = '../lab'": "robot .*'lab'",
    "[robot]\nname = 'x'": r"\[robot\] size",
    "background = 'floor.png'": r"\[background\]",
    "colors.red = 3": r"\[colors\] red",
    "[colors.red]\nu = [3, 256]": r"line 2: \[colors\.red\] u",
    "[colors.red]\nw = [3, 2]": r"line 2: \[colors\.red\] .*'w'",
    "[colors.red]\ny = [1, false]": r"\] y .*False",
    "[markers]\nred = [1, 2]": r"\[markers\] .*'red'",
    "[markers]\nright.position = [1, 2]\nleft.position = 'x'": r"line 3: .*left\] position",
    "[markers]\nright.color = 'y'\nleft.color = 'x'": r"\[markers\.right\] position",
    "[markers]\nright.position = [1, 2]\nleft.position = [1, 2]": r"\[markers\] distance",
    "[markers]\nright.position = [1, 2]\nleft.position = [1, 3]": "right marker",
    f"[markers]\nleft.position = [1, 2]\nright.position = [{'1, ' * 10_001}]": r"right\] position",
    "[noise]\npercent = 1": r"\[noise\] kind .*'UniformNoise', 'GaussianNoise'",
    "[noise]\nkind = 'os.system'\npercent = 1": r"\[noise\] kind",
    "[noise]\nkind = 'UniformNoise'\npercnt = 1": "'percnt'.*'percent'",
    "[noise]\nkind = 'UniformNoise'": r"\[noise\].*percent",
    "[dropout]\nprobability = 2": r"\[dropout\] probability",
    "[process_noise]\nkind = 'PoseNoise'\ncovariance = [[1]]": r"\[process_noise\] covariance",
    "[model]\nkind = 'RobotModel'": r"\[model\] theta",
    "[model]\nkind = 'RobotParameters'\nmass = -1": r"\[model\] mass",
    "[control]\nkind = 'DriveAround'\nhold = 0": r"\[control\] hold",
    "[control]\nkind = 'Replay'\nu = 'ä'": r"\[control\] u",
    "[control]\nkind = 'Replay'\nu = 'AAAA'": r"\[control\] u",
    f"[background]\npixels = '{png('RGB', (8193, 8192))}'": "pixels",
    f"[background]\npixels = '{png('RGBA', (5, 5))}'": "background",
    "[background]\npixels = 'AAAA'": "pixels",
    "format = 2": "format",
    "a = " + "[" * 10_000: "TOML",
}


@pytest.mark.long
def test_what_is_wrong_in_a_file(tmp_path):
    for text, says in REFUSED.items():
        (tmp_path / "run.toml").write_text(text, encoding="utf-8")
        for read, where in (
            (lambda text: Scenario.load(tmp_path / "run.toml"), r"run\.toml[:,] "),
            (Scenario.from_toml, "scenario[:,] "),
        ):
            with pytest.raises(ValueError, match=f"(?s){where}.*{says}") as caught:
                read(text)
            assert len(str(caught.value)) < 1000


def test_files_that_are_none(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"missing\.toml"):
        Scenario.load(tmp_path / "missing.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\0")
    with pytest.raises(ValueError, match=r"bytes\.toml"):
        Scenario.load(tmp_path / "bytes.toml")
    with pytest.raises(TypeError, match="text"):
        Scenario.from_toml(b"area = [300, 200]")


def test_what_is_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.simulation.scenario_file.MOST_BYTES", 2**20)
    large = Scenario(control=Replay(np.ones((2**17, 2))))
    with pytest.raises(ValueError, match="1 MB, got one of 2 MB"):
        large.save(tmp_path / "run.toml")
    assert not list(tmp_path.iterdir())
    (tmp_path / "run.toml").write_text("#" * (2**20 + 1))
    with pytest.raises(ValueError, match=r"run\.toml .*1 MB"):
        Scenario.load(tmp_path / "run.toml")
    with pytest.raises(ValueError, match="1 MB"):
        Scenario.from_toml("#" * (2**20 + 1))
    (tmp_path / "run.toml").write_text("#" + "-" * (2**20 - 1))
    assert Scenario.load(tmp_path / "run.toml") == Scenario()
    pictured = Scenario(background=np.zeros((8, 10, 3), np.uint8))
    monkeypatch.setattr("robsim.vision.imaging.images.MOST_PIXELS", 79)
    with pytest.raises(ValueError, match="79 px, got 10 x 8"):
        pictured.to_toml()


@pytest.mark.long
@settings(max_examples=50)
@given(st.dictionaries(st.sampled_from(list(FULL.changes())), st.from_type(type) | st.integers()))
def test_whatever_stands_there_is_an_error_or_a_scenario(values):
    text = "\n".join(f"{name} = {value!r}" for name, value in values.items())
    with contextlib.suppress(ValueError):
        assert isinstance(Scenario.from_toml(text), Scenario)


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        Scenario().save(tmp_path / "nowhere" / "run.toml")
    assert caught.value.filename == str(tmp_path / "nowhere" / "run.toml")
