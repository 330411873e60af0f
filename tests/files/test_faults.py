"""Whatever fails, and whenever the process is killed: a file is the old one or the new one."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

import sanitizers
from sizes import thorough

SUPPORT = Path(__file__).parents[1] / "support"
COMPILER = shutil.which("cc") or shutil.which("gcc")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (COMPILER and sys.platform == "linux"), reason="needs a C compiler"),
]


def survived(folder, kind, *writers):
    """Try the faults of a kind on some writers, in a process of its own."""
    library = folder / "faults.so"
    source = str(SUPPORT / "faults.c")
    command = [COMPILER, "-shared", "-fPIC", "-Wall", "-Werror", "-o", str(library), source, "-ldl"]
    subprocess.run(command, check=True)
    if sanitizers.ADDRESS:
        pytest.skip("the sanitizer must be loaded first")
    environment = {**os.environ, "LD_PRELOAD": str(library), "OPENBLAS_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(sys.path)
    program = [sys.executable, "-W", "error", str(SUPPORT / "faults.py"), str(folder), kind]
    done = subprocess.run([*program, *writers], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert {line.split(": ")[0] for line in done.stdout.splitlines()} == set(writers)


@pytest.fixture
def memory():
    """A folder in memory: on a disk, most of the time goes into bringing files to it."""
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        yield Path(folder)


WRITERS = (
    *("csv", "scenario", "settings", "rotated robot", "removed robot"),
    *thorough(("trace", "picture", "clip", "figure", "colours"), ()),
)
KINDS = ("errors", "kills", "random")


@pytest.mark.parametrize("kind", KINDS)
def test_every_writer_survives_all_of_it(memory, kind):
    robot = ("robot",) if kind == "kills" else thorough(("robot",), ())
    survived(memory, kind, *WRITERS, *robot)


@pytest.mark.parametrize("kind", KINDS)
def test_videos_survive_all_of_it(tmp_path, kind):
    pytest.importorskip("cv2")
    survived(tmp_path, kind, "mp4", *thorough(("mkv",), ()))


def test_each_allocation_fails_in_turn(memory):
    # Not of a file whose reader makes native values: pybind11 3.1 writes into the memory of a new
    # instance without a look at whether Python gave it any.
    pytest.importorskip("_testcapi")
    survived(memory, "memory", "csv", *thorough(("trace",), ()))
