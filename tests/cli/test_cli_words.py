"""What the shell shows: its own options, no types of Python, whole tables, files by name."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from disks import full_disk
from robsim.cli import app, errors

pytestmark = pytest.mark.long

COMMANDS = [
    (), ("run",), ("track",), ("new",), ("demo",), ("bench",), ("notebooks",), ("robots",),
    ("gui",), ("live",), ("cameras",), ("colors",), ("robots", "add"), ("robots", "rotate"),
    ("colors", "train"), ("colors", "frame"),
]  # fmt: skip


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def shell(*arguments, **variables):
    """The outcome of a command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "robsim", *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env=os.environ | variables,
        check=False,
    )


def refused(*arguments):
    """What a command that ends with status 2 says."""
    result = CliRunner().invoke(app, arguments, env={"COLUMNS": "200"})
    assert result.exit_code == 2, result.output
    return result.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_no_types_of_python(command):
    text = CliRunner().invoke(app, [*command, "--help"]).stdout
    for kind in ("<bool>", "<int>", "<float>", "<str>", "<path>", "<list", "INTEGER"):
        assert kind not in text


def test_help_counts_the_slots():
    assert "Write the 8 default callbacks" in CliRunner().invoke(app, ["new", "--help"]).stdout


def test_messages_name_the_options_of_the_command():
    with errors.naming_options({"steps": "--steps", "limit_y": "--limit-y", "pixels": "--pixels"}):
        words = errors.in_words_of_the_shell
        assert words("steps must be 3") == "--steps must be 3"
        assert words("pixels and steps must differ") == "--pixels and --steps must differ"
        assert words("grey: limit_y=True helps") == "grey: --limit-y helps"
        assert words("longer than limit_y = 3") == "longer than --limit-y = 3"
        assert words("give estimate_state=...") == "give a file estimate_state.py"
        # A callback's file speaks of its function.
        assert words("mine/steps.py: steps must return") == "mine/steps.py: steps must return"
    assert errors.in_words_of_the_shell("steps must be 3") == "steps must be 3"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "--steps", "5.5"), "it must be a whole number, got '5.5'"),
        (("run", "--time-limit", "short"), "it must be a number such as 0.5, got 'short'"),
        (("bench", "--rounds", "0"), "--rounds must lie within 1.."),
        (("bench", "--camera", "--rounds", "0"), "--rounds must lie within 1.."),
        (("run", "--area", "3x4"), "--area must lie within 16..16384 px, got 3x4"),
        (
            ("run", "--control", "follow-path:9,3", "8,3"),
            "put quotes around the points, as 'follow-path:9,3 8,3'",
        ),
        (("colors", "frame", "f.xyz"), "f.xyz: the name of an image must end in .png"),
        (("colors", "frame", "--at", "1200,3"), "--at must lie within the image"),
        (("colors", "frame", "--heading", "nan"), "--heading must be finite (degrees)"),
        (("track", "rtsp://camera"), "for a live camera, give its frames to robsim.Experiment"),
        (("track", "/dev/video0"), "for a live camera, give its frames to robsim.Experiment"),
        (("run", "--out", f"{__file__}/out"), f"{__file__} is a file, not a folder"),
    ],
)
def test_a_mistake_is_told_in_words_of_the_shell(arguments, message):
    assert message in refused(*arguments)


def test_an_option_of_a_file_that_there_is_not():
    Path("task.toml").write_text("[scenario]\nseed = 3\n")
    assert "there are robot, area, resolution" in refused("run", "--scenario", "task.toml")


def test_a_folder_with_a_space_is_quoted():
    assert "robsim run 'my folder'" in CliRunner().invoke(app, ["new", "my folder"]).stdout


@pytest.mark.usefixtures("undrawn")
def test_no_steps_replace_no_earlier_run():
    CliRunner().invoke(app, ["run", "--steps", "2"])
    result = CliRunner().invoke(app, ["run", "--steps", "0"])
    assert result.stderr == "no steps, no results\n"


@pytest.mark.usefixtures("undrawn")
def test_json_tells_on_stderr_why_it_is_empty():
    result = CliRunner().invoke(app, ["run", "--steps", "2", "--json"])
    assert result.stdout == "{}\n"
    assert "not tracked: add --measure" in result.stderr


def test_a_narrow_terminal_cuts_no_table():
    text = CliRunner(env={"COLUMNS": "40"}).invoke(app, ["robots", "list"]).stdout
    assert "…" not in text
    for word in ("lab", "robot2", "sheep", "faces right", "markers apart", "54.4 px", "shipped"):
        assert word in text


def test_a_terminal_without_the_sign_for_degrees():
    result = shell("robots", "list", PYTHONIOENCODING="ascii")
    assert result.returncode == 0, result.stderr
    assert "90?, faces up" in result.stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_an_output_that_cannot_be_written():
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [sys.executable, "-m", "robsim", "colors", "list"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert result.returncode == 2
    assert result.stderr.startswith("error: the output cannot be written: No space left on device")


@pytest.mark.parametrize(
    ("command", "file"),
    [
        (("new", "mine"), "mine/define_model.py"),
        (("colors", "frame", "f.png"), "f.png"),
        (("robots", "add", "mine", "lab"), "data/robots/mine"),
    ],
)
def test_a_full_disk_names_the_file_and_keeps_no_part(command, file, tmp_path, monkeypatch):
    monkeypatch.setenv("ROBSIM_DATA", "data")
    with full_disk(100):
        result = CliRunner().invoke(app, command)
    assert result.exit_code == 2
    assert result.stderr == f"error: {file}: File too large\n"
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


@pytest.mark.parametrize(
    "command",
    [
        ("robots", "show", "lab", "--out", "a.xyz"),
        ("colors", "train", "f.png", "--name", "red", "--region", "578,613,594,630",
         "--figure", "a.xyz"),
    ],
)  # fmt: skip
def test_a_figure_of_no_known_format(command):
    CliRunner().invoke(app, ["colors", "frame", "f.png", "--robot", "lab"])
    assert refused(*command).startswith("error: a.xyz: the name of a figure must end in .png")
