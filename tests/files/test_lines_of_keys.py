"""An error in a TOML file names the line, the table and the key, in every reader."""

import re

import pytest

import robsim
from robsim.teach import AssignmentError, load_assignment
from robsim.vision import load_calibration, save_robot

IMAGE = "'''\nAA==\n= [noise]\n'''"
# A scenario, and where it is wrong.
SCENARIOS = {
    "area = [300, 200]\n\nsmothing = 3": "line 3: .*'smothing'.*'smoothing'",
    "# area = 1\narea = [1, 2]": "line 2: area must",
    "[dropout]\nprobability = 0.5\n[noise]\nkind = 'UniformNoise'\npercent = 'x'": (
        r"line 5: \[noise\] percent must be a number, got 'x'"
    ),
    "noise.kind = 'UniformNoise'\nnoise.percent = -1": r"line 2: \[noise\] percent must",
    "markers = { left.position = 1 }": r"line 1: \[markers\.left\] position",
    "[markers.left]\nposition = [1, 2]\n[markers.right]\nposition = [1, 3]\narea = 'x'": (
        r"line 5: \[markers\.right\] area must be a number, got 'x'"
    ),
    f"background.pixels = {IMAGE}\n[noise]\nkind = 3": r"line 1: \[background\] pixels must be",
    "[model]\nkind = 'RobotModel'": r"line 1: \[model\] theta is missing",
    '[colors."a.b"]\ny = 3': r"\[colors\.a\.b\] y must",
}


@pytest.mark.parametrize(("text", "words"), SCENARIOS.items())
def test_of_a_scenario(text, words):
    with pytest.raises(ValueError, match=f"^scenario(, )?.*{words}"):
        robsim.Scenario.from_toml(text)


def test_of_a_robot_and_a_calibration(tmp_path):
    save_robot(tmp_path, robsim.load_robot("lab"))
    file = tmp_path / "robot.toml"
    text = file.read_text().replace('color = "red"', "color = 3")
    file.write_text(text)
    line = text.partition("color = 3")[0].count("\n") + 1
    with pytest.raises(ValueError, match=rf"robot\.toml, line {line}: \[markers\.right\] color"):
        robsim.load_robot(tmp_path)
    file.write_text("format = 1\n[frames]\nsize = [640, 480]\nregin = 3\n")
    with pytest.raises(ValueError, match=r"line 4: \[frames\] .*'regin': did you mean 'region'"):
        load_calibration(file)


def test_of_a_list_of_tables(tmp_path):
    test = '[[tests]]\nname = "%s"\ntask = "park"\npoints = %s\npublic = true\n'
    text = 'name = "x"\ntitle = "x"\n' + test % ("a", 1) + test % ("b", "[]")
    (tmp_path / "assignment.toml").write_text(text)
    with pytest.raises(AssignmentError, match=re.escape("line 11: [tests.2] points must be")):
        load_assignment(tmp_path)
