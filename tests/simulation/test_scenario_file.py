import base64
import contextlib
import io
import re
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import robsim
from robsim import Replay, Scenario
from robsim.simulation import _scenario_file
from robsim.simulation._scenario import OPTIONS
from robsim.simulation._scenario_file import _KINDS, _PLAIN
from scenarios import FULL, scenarios

# --- there and back


def check_a_file_gives_it_again(scenario):
    text = scenario.to_toml()
    again = Scenario.from_toml(text)
    assert again == scenario
    assert again.to_toml() == text


@pytest.mark.long
@settings(max_examples=25)
@given(scenarios())
def test_a_file_gives_the_scenario_again(scenario):
    check_a_file_gives_it_again(scenario)


@pytest.mark.slow
@pytest.mark.sanitized
@given(scenarios())
def test_a_file_gives_each_of_many_scenarios_again(scenario):
    check_a_file_gives_it_again(scenario)


def test_all_options_at_once(tmp_path):
    FULL.save(tmp_path / "full.toml")
    again = Scenario.load(tmp_path / "full.toml")
    assert again == FULL
    assert np.array_equal(again.robot.image, FULL.robot.image)
    assert np.array_equal(again.background.pixels, FULL.background.pixels)


@pytest.mark.long
@given(st.floats(-1e300, 1e300), st.floats(-1e300, 1e300))
def test_every_bit_of_a_number_is_kept(one, other):
    for control in (robsim.Spin(one), Replay([(one, other)])):
        again = Scenario.from_toml(Scenario(control=control).to_toml()).control
        numbers = [value.hex() for value in np.ravel(getattr(again, "u", one)).tolist()]
        assert again == control
        assert one.hex() in numbers


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
    robsim.robots.set_default_robot("sheep")
    assert 'robot = "sheep"' in Scenario().to_toml()


@pytest.mark.long
def test_a_robot_that_another_machine_does_not_have(user_folder, tmp_path):
    robsim.robots.add_robot("mine", robsim.load_robot("robot2"))
    scenario = Scenario(robot="mine")
    scenario.save(tmp_path / "run.toml")
    robsim.robots.remove_robot("mine")
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
    "areas = [3, 3]": "no option 'areas': did you mean 'area'",
    "control_ = 3": "no option 'control_': did you mean 'control'",
    "area = [1, 2]": "area must",
    "area = 'wide'": "area must",
    "boundary = 3": "boundary must",
    "headings = 0": "headings must",
    "headings = false": "headings must",
    "camera_delay = 1e3": "camera_delay must",
    "camera_delay = 0.5": "camera_delay must",
    "motor_delay = 1e4": "motor_delay must",
    "motor_delay = '2'": "motor_delay must be a number",
    "motor_delay = true": "motor_delay must be a number",
    "measure = 1": "measure must",
    "start = 2020-01-01": "start must",
    "start = [1, 2, nan]": "start must",
    "seed = -1": "seed must",
    "seed = 'x'": "seed must be a whole number",
    "[seed]\nentropy = [1, -1]": r"\[seed\] entropy must",
    "[seed]\nentropy = 1\nspawn_key = 'x'": r"\[seed\] spawn_key must",
    "robot = '/etc'": "robot must be one of 'lab'",
    "robot = '../lab'": "robot must be one of",
    "robot = 3": "robot must",
    "[robot]\nname = 'x'": r"\[robot\] image is missing",
    "background = 'floor.png'": r"background must be a table \[background\]",
    "colors = 'colors.toml'": r"colors must be tables such as \[colors.red\]",
    "colors.red = 3": r"\[colors\] \[red\] a colour must be a table",
    "[colors]": "colors must have at least one",
    "[colors.red]\nu = [3, 2]": r"\[red\]",
    "[colors.red]\nu = [3, 256]": r"\[red\] u must",
    "[colors.red]\nw = [3, 2]": r"\[red\] there is no key 'w'",
    "markers = 'sheep'": "markers must be a table",
    "[markers.right]\nposition = [1, 2]": r"\[markers\] markers must be by the roles 'right'",
    "[markers]\nred = [1, 2]": r"\[markers\] there is no key 'red'",
    "[markers]\nright.position = [1, 2]\nleft.position = 'x'": r"left\.position must",
    "[markers]\nright.position = [1, 2]\nleft.color = 'x'": r"\[markers\] positions must",
    "[markers]\nright.color = 'y'\nleft.color = 'x'": r"\[markers\] position is missing",
    "[markers]\nright.position = [1, 2]\nleft.position = [1, 2]": r"\[markers\] distance",
    "[markers]\nright.position = [1, 2]\nleft.position = [1, 3]": r"right marker must lie farther",
    "[markers]\nback.position = [1, 2]\nleft.position = [1, 3]": r"must be by the roles",
    "[markers]\nright.place = [1, 2]\nleft.place = [1, 3]": r"markers\.right must have color, po",
    "[markers]\nright = [1, 2]\nleft = [1, 3]": r"markers\.right must be a table",
    "[noise]\npercent = 1": r"\[noise\] kind is missing, one of 'GaussianNoise', 'UniformNoise'",
    "[noise]\nkind = 'os.system'\npercent = 1": r"\[noise\] kind must be one of",
    "[noise]\nkind = 'UniformNoise'\npercnt = 1": "no key 'percnt': did you mean 'percent'",
    "[noise]\nkind = 'UniformNoise'\npercent = 'x'": r"\[noise\] percent must",
    "[noise]\nkind = 'UniformNoise'": r"\[noise\].*percent",
    "[dropout]\nprobability = 2": r"\[dropout\] probability must",
    "[dropout]\nprobability = 1\nsteps = 1.0": r"\[dropout\] steps must",
    "[process_noise]\nkind = 'PoseNoise'\ncovariance = [[1]]": r"\[process_noise\] covariance must",
    "[mismatch]\nsigma = 1": r"\[mismatch\] sigma must",
    "[model]\nkind = 'RobotModel'": r"\[model\] theta is missing",
    "[model]\nkind = 'RobotModel'\ntheta = 3": r"\[model\] theta must",
    "[model]\nkind = 'RobotParameters'\nmass = '1'": r"\[model\] mass must",
    "[model]\nkind = 'RobotParameters'\nmass = -1": r"\[model\] mass",
    "[model]\nkind = 'RobotParameters'\nmotor_gain = [1]": r"\[model\] motor_gain must",
    "[control]": r"\[control\] kind is missing",
    "[control]\nkind = 'DriveAround'\nhold = 0": r"\[control\] hold must",
    "[control]\nkind = 'DriveAround'\nhold = 99999999999": r"\[control\] hold must",
    "[control]\nkind = 'Replay'\nu = 'ä'": r"\[control\] u must be base64",
    "[control]\nkind = 'Replay'\nu = 'AAAA'": r"\[control\] u must be pairs of float64",
    "[control]\nkind = 'Replay'\nu = [1]": r"\[control\] u must be a text",
    "[evaluate_model]\nkind = 'eval'": r"\[evaluate_model\] kind must",
    f"[background]\npixels = '{png('RGB', (5001, 5000))}'": "pixels must be RGB or RGBA of at most",
    f"[background]\npixels = '{png('L', (5, 5))}'": r"pixels must be RGB or RGBA",
    f"[background]\npixels = '{png('RGBA', (5, 5))}'": r"background must have the shape",
    "[background]\npixels = 'AAAA'": r"pixels must be a PNG image",
    "format = 2": "format must be 1",
    "a = 1\na = 2": "this is not TOML",
    "seed = " + "9" * 5000: "this is not TOML",
    "a = " + "[" * 10_000: "this is not TOML",
    f"start = [{'9' * 400}, 0, 0]": "",
    f"[markers]\nleft.position = [1, 2]\nright.position = [{'1, ' * 10_001}]": (
        "right.position must have at most 10000 rows"
    ),
}


@pytest.mark.long
@pytest.mark.parametrize(("text", "says"), REFUSED.items(), ids=[text[:50] for text in REFUSED])
def test_what_is_wrong_in_a_file(text, says, tmp_path):
    (tmp_path / "run.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"(?s)scenario file .*run\.toml: .*" + says) as caught:
        Scenario.load(tmp_path / "run.toml")
    assert len(str(caught.value)) < 1000
    assert "incompatible" not in str(caught.value)
    with pytest.raises(ValueError, match="scenario: .*" + says):
        Scenario.from_toml(text)


def test_files_that_are_none(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"missing\.toml"):
        Scenario.load(tmp_path / "missing.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match=r"bytes\.toml .*UTF-8"):
        Scenario.load(tmp_path / "bytes.toml")
    for path in (None, 5):
        with pytest.raises(TypeError, match="path must"):
            Scenario.load(path)
        with pytest.raises(TypeError, match="path must"):
            Scenario().save(path)
    with pytest.raises(TypeError, match="text must be a str"):
        Scenario.from_toml(b"area = [300, 200]")


def test_what_is_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr(_scenario_file, "MOST_BYTES", 2**20)
    large = Scenario(control=Replay(np.ones((2**17, 2))))
    with pytest.raises(ValueError, match="fit into a file of 1 MB, got one of 2 MB"):
        large.save(tmp_path / "run.toml")
    assert not list(tmp_path.iterdir())
    (tmp_path / "run.toml").write_text("#" * (2**20 + 1))
    with pytest.raises(ValueError, match=r"run\.toml must have at most 1 MB"):
        Scenario.load(tmp_path / "run.toml")
    with pytest.raises(ValueError, match="at most 1 MB"):
        Scenario.from_toml("#" * (2**20 + 1))
    monkeypatch.setattr(_scenario_file, "MOST_PIXELS", 79)
    with pytest.raises(ValueError, match="at most 79 px, got 10 x 8"):
        Scenario(background=np.zeros((8, 10, 3), np.uint8)).to_toml()


@pytest.mark.long
@given(st.dictionaries(st.sampled_from(list(FULL.changes())), st.from_type(type) | st.integers()))
def test_whatever_stands_there_is_an_error_or_a_scenario(values):
    text = "\n".join(f"{name} = {value!r}" for name, value in values.items())
    with contextlib.suppress(ValueError):
        assert isinstance(Scenario.from_toml(text), Scenario)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "seed = 1979-05-27T07:32:00Z",
            "whole number, or a table [seed], got the time 1979-05-27T",
        ),
        ("measure = 1", "measure must be true or false, got 1"),
        ("smoothing = true", "smoothing must be a whole number, got true"),
        ("boundary = {}", "boundary must be a text, got a table"),
        ("area = '5x5'", "area must be [width, height] in px, got '5x5'"),
        ("[noise]\npercent = 5", "[noise] kind is missing, one of 'GaussianNoise', 'UniformNoise'"),
        ("[dropout]\nprobability = 0.1\nsteps = 1.5", "[dropout] steps must be a whole number"),
        ("[dropout]\nprobability = 07:32:00", "must be a number, got the time 07:32:00"),
        ("[colors.red]\ny = [1, false]", "y must be [lower, upper], two whole numbers, got false"),
    ],
)
def test_errors_speak_of_what_toml_has(text, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Scenario.from_toml(text)


def test_every_option_has_its_type_in_a_file():
    assert _PLAIN.keys() | _KINDS.keys() | {"colors"} == set(OPTIONS)


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        Scenario().save(tmp_path / "nowhere" / "run.toml")
    assert caught.value.filename == str(tmp_path / "nowhere" / "run.toml")
