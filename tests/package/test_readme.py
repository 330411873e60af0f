"""The README and programs of pages run as a reader would run them."""

import contextlib
import io
import re
import subprocess
import sys

import numpy as np
import pytest

import robsim
from commands import command
from prose import PAGES, README, ROOT, blocks, page
from sizes import thorough

pytestmark = pytest.mark.long

BLOCKS = [one for page in (README, *PAGES) if page.stem != "sensitivity" for one in blocks(page)]
GRADING = [block for block in BLOCKS if "def test_" in block]
PROGRAMS = [block for block in BLOCKS if block not in GRADING]
LABS = [block for block in PROGRAMS if "send=motors" in block]

# Verdicts that pages print.
VERDICTS = (
    "robsim.score_path(trace, square)",
    "robsim.identifiability(trace)",
    'robsim.batch_estimate(trace, method="output_error")',
    "robsim.pose_consistency(traces)",
    "robsim.batch_estimate(trace)",
)


def python(*arguments, cwd):
    words = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True)


@pytest.mark.slow
def test_the_grading_passes_right_callbacks_and_fails_wrong_and_untouched_ones(tmp_path):
    (grading,) = GRADING
    (line,) = re.findall(r"^python (-m pytest .*)$", page("own_tests"), re.MULTILINE)
    grade = (*line.split(), "-p", "pytest_robsim", "-p", "no:cacheprovider", "-q")
    (tmp_path / "grade_public.py").write_text(grading)
    command("new", "mine", cwd=tmp_path)
    for file in ("evaluate_model.py", "define_model.py", "control.py"):  # none of theirs
        (tmp_path / "mine" / file).write_text("raise SystemExit('I own the world')\n")
    untouched = python(*grade, cwd=tmp_path)
    assert "nothing is handed in" in untouched.stdout, untouched.stdout
    file = tmp_path / "mine/measure.py"
    text = file.read_text().replace("ENABLED = False", "")
    file.write_text(text.replace("    return robsim", "    found = robsim") + "    return found\n")
    passed = python(*grade, cwd=tmp_path)
    assert "3 passed" in passed.stdout, passed.stdout
    text = "import os\n\n\ndef measure(step):\n    os._exit(0)\n"
    (tmp_path / "mine/measure.py").write_text(text)
    failed = python(*grade, cwd=tmp_path)
    assert "3 failed" in failed.stdout, failed.stdout
    assert failed.returncode == 1


@pytest.mark.slow
@pytest.mark.parametrize("expression", VERDICTS)
def test_the_examples_give_the_same_verdict_for_other_seeds(expression):
    wanted = re.sub(r"\s", "", expression)
    shown = [block for block in PROGRAMS if wanted in re.sub(r"\s", "", block)]
    assert shown
    for block in shown:
        verdicts = {verdict_of(block, expression, seeds) for seeds in range(thorough(6, 2))}
        assert len(verdicts) == 1, verdicts


def verdict_of(block, expression, seeds):
    """Run a block with other seeds, and return the verdict of what it prints."""
    if "range(20)" in block:
        first = 20 * (seeds + 1)
        other = block.replace("range(20)", f"range({first}, {first + 20})")
    else:
        other = block.replace("seed=1", f"seed={2 + seeds}")
    assert other != block
    names = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(other, names)
    report = eval(expression, names)
    if "pose_consistency" in expression:
        assert (report.verdict, report.inside > 0.85) == ("consistent", True)
    return getattr(report, "identifiability", report).verdict


@pytest.mark.slow
def test_the_robot_of_the_lab_drives_and_is_stopped(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = LABS
    names = {}
    exec(block, names)
    x, y, _ = names["trace"].pose_measured[-1]
    assert 320 < x < 620
    assert abs(y - 300) < 5
    assert names["trace"].u.any()
    assert names["lab"].receiver.events[-1].kind == "stop"
    assert not names["lab"].receiver.input.any()
    assert len(names["other"]) == 50


def test_the_first_block_is_five_lines_and_ends_with_a_picture():
    lines = [line for line in BLOCKS[0].splitlines() if line]
    assert len(lines) == 5
    names = {}
    exec(BLOCKS[0].replace("robsim.plot", "figure = robsim.plot"), names)
    assert names["figure"]._repr_png_().startswith(b"\x89PNG")
    assert names["trace"].seen.all()
    assert np.ptp(names["trace"].pose_true[:, :2], axis=0).max() > 100  # the robot drives


def test_the_pages_name_what_there_is():
    rows = re.findall(r"^\| `(\w+)` \|.*\|.*\|.*\|$", page("callbacks"), re.MULTILINE)
    assert rows == [*robsim.Simulation.SLOTS]
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    assert len(text.encode()) <= 8000
    if not (ROOT / "run").is_file():
        pytest.skip("needs the sources")
    script = (ROOT / "run").read_text()
    for word in re.findall(r"^\./run (\w+)", text, re.MULTILINE):
        assert re.search(rf"^  (\w+ \| )*{word}( \| \w+)*\)", script, re.MULTILINE)
