"""Every block of the README runs as a reader would run it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

README = (Path(__file__).parent.parent / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_a_block_runs_on_its_own(block, tmp_path):
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", block], cwd=tmp_path, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr


def test_the_first_block_is_five_lines_and_ends_with_a_picture():
    lines = [line for line in BLOCKS[0].splitlines() if line]
    assert len(lines) <= 5
    names = {}
    exec(BLOCKS[0].replace("robsim.plot", "figure = robsim.plot"), names)
    assert names["figure"]._repr_png_().startswith(b"\x89PNG")


def test_the_table_of_callbacks_names_every_slot():
    from robsim.simulation import ONCE_SLOTS, STEP_SLOTS

    rows = re.findall(r"^\| `(\w+)` \|.*\|.*\|.*\|$", README, re.MULTILINE)
    assert rows == [*ONCE_SLOTS, *STEP_SLOTS]


@pytest.mark.skipif(
    not Path(__file__).parent.with_name("assets").is_dir(), reason="needs the sources"
)
def test_the_pictures_are_there():
    for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).parent.parent / name).is_file()


def test_each_command_of_the_shell_block_is_a_command_of_run():
    script = Path(__file__).parent.with_name("run")
    if not script.is_file():
        pytest.skip("needs the sources")
    commands = re.findall(r"^\./run (\w+)", README, re.MULTILINE)
    assert commands == ["demo", "test"]
    for command in commands:
        assert re.search(rf"^  {command}\)", script.read_text(), re.MULTILINE)
