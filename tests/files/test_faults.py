"""Whatever fails, and whenever the process is killed: a file is the old one or the new one."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sanitizers

SUPPORT = Path(__file__).parents[1] / "support"
COMPILER = shutil.which("cc") or shutil.which("gcc")

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not (COMPILER and sys.platform == "linux"), reason="needs a C compiler"),
]


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    """A function that tries the faults of a kind on some writers, in a process of its own."""
    folder = tmp_path_factory.mktemp("faults")
    library = folder / "faults.so"
    source = str(SUPPORT / "faults.c")
    command = [COMPILER, "-shared", "-fPIC", "-Wall", "-Werror", "-o", str(library), source, "-ldl"]
    subprocess.run(command, check=True)

    def run(kind, *writers):
        environment = {**os.environ, "LD_PRELOAD": str(library), "OPENBLAS_NUM_THREADS": "1"}
        environment["PYTHONPATH"] = os.pathsep.join(sys.path)
        if sanitizers.ADDRESS:
            pytest.skip("the sanitizer must be loaded first")
        program = [sys.executable, "-W", "error", str(SUPPORT / "faults.py"), str(folder), kind]
        done = subprocess.run(
            [*program, *writers], env=environment, capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return dict(line.split(": ") for line in done.stdout.splitlines())

    return run


@pytest.mark.slow
def test_a_trace_and_a_table_survive_each_error_of_the_disk(tried):
    assert set(tried("errors", "trace", "csv", "scenario")) == {"trace", "csv", "scenario"}


@pytest.mark.slow
def test_the_settings_survive_a_kill_at_each_call(tried):
    assert set(tried("kills", "settings")) == {"settings"}


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("kind", ["errors", "kills", "random"])
def test_every_writer_survives_all_of_it(tried, kind):
    pytest.importorskip("cv2")
    assert len(tried(kind)) == 13


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_each_allocation_fails_in_turn(tried):
    # Not of a file whose reader makes native values: pybind11 3.1 writes into the memory of a new
    # instance without a look at whether Python gave it any.
    pytest.importorskip("_testcapi")
    assert set(tried("memory", "trace", "csv")) == {"trace", "csv"}
