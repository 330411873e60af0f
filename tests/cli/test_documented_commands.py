"""Every command of the README and every example of a --help, run as it stands there."""

import re
import shlex
from pathlib import Path

import pytest
import typer

from commands import command as run_command
from photographed_sheets import OBLIQUE, board_pictures, floor_picture
from robsim.cli import app
from robsim.lab import Chessboard
from robsim.vision import load_robot, save_image, save_robot

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
SHELL = "".join(re.findall(r"```sh\n(.*?)```", README, re.DOTALL))


def commands_of(group):
    for command in group.commands.values():
        command = command.loaded() if hasattr(command, "loaded") else command
        if hasattr(command, "commands"):
            yield from commands_of(command)
        else:
            yield command


def examples():
    for command in commands_of(typer.main.get_command(app)):
        assert command.epilog, f"{command.name} --help has no example"
        yield command.epilog.removeprefix("Example: ")


def typed(lines):
    """Return the command lines of robsim, each once."""
    commands = [line.partition("#")[0].strip() for line in lines]
    return list(dict.fromkeys(line for line in commands if line.startswith("robsim ")))


# As many steps as show that the command works.
SHORTER = {
    "--steps 300": "--steps 60",
    "--steps 50": "--steps 6",
    "--steps 100": "--steps 20",
    "robsim demo": "robsim demo --steps 100",
    "--seconds 15": "--steps 20 --frame-timeout 300",
    "robsim bench": "robsim bench --rounds 1",
    "tasks try park": "tasks try park --runs 1",
}


# These take an assignment, and minutes: tests/assignments/test_commands.py.
ELSEWHERE = ("robsim assignment ", "robsim grade hw")


@pytest.mark.slow
@pytest.mark.usefixtures("user_folder", "small_bench", "closed_page")
def test_all_of_them_work_one_after_the_other(tmp_path):
    save_robot(tmp_path / "sheep", load_robot("sheep"))
    (tmp_path / "sheep/robot.png").rename(tmp_path / "photo.png")
    (tmp_path / "pictures").mkdir()
    for number, image in enumerate(board_pictures(Chessboard(9, 6, 25), farther=1.3)):
        save_image(tmp_path / f"pictures/{number}.png", image)
    save_image(tmp_path / "floor.png", floor_picture(OBLIQUE))
    for line in typed([*SHELL.splitlines(), *examples()]):
        for long, short in SHORTER.items():
            line = line.replace(long, short)
        if line.startswith(ELSEWHERE):
            continue
        words = shlex.split(line)[1:]
        run = run_command(*words, cwd=tmp_path)
        # What one begins with solves no task; a busy machine is not as fast as a camera.
        is_tried = line.startswith(("robsim tasks try", "robsim check parking"))
        expected = {1} if is_tried else {0, 1} if "--check" in words else {0}
        assert run.exit_code in expected, f"{line}: {run.stderr}"
        assert run.stdout.strip(), line
