"""Whatever fails, and whenever the run is killed: what was written can be read, and agrees."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import surroundings
from sizes import thorough

pytest.importorskip("cv2")

SUPPORT = Path(__file__).parents[1] / "support"
COMPILER = shutil.which("cc") or shutil.which("gcc")

pytestmark = pytest.mark.long


def run_program(name, *arguments, **environment):
    """Run a program of tests/support; return what it prints."""
    variables = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment}
    variables["PYTHONPATH"] = os.pathsep.join(sys.path)
    program = [sys.executable, "-W", "error", str(SUPPORT / name), *map(str, arguments)]
    done = subprocess.run(program, env=variables, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_killed_runs_lose_at_most_one_step(tmp_path, rng):
    seed, count = int(rng.integers(2**31)), thorough(50, 10)
    assert "killed" in run_program("killed_sessions.py", tmp_path, seed, count)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The library that lets calls to the system fail."""
    if not (COMPILER and sys.platform == "linux"):
        pytest.skip("needs a C compiler")
    if surroundings.ADDRESS_SANITIZER:
        pytest.skip("the sanitizer must be loaded first")
    path = tmp_path_factory.mktemp("faults") / "faults.so"
    source = str(SUPPORT / "faults.c")
    command = [COMPILER, "-shared", "-fPIC", "-Wall", "-Werror", "-o", str(path), source, "-ldl"]
    subprocess.run(command, check=True)
    return str(path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["errors", "kills"])
def test_a_fault_at_any_call_leaves_a_session_that_agrees(library, tmp_path, kind):
    assert kind in run_program("session_faults.py", tmp_path, kind, LD_PRELOAD=library)
