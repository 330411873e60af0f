"""Whatever fails, and whenever the process is killed: a file is the old one or the new one."""

import importlib.util
import os
import shutil
import subprocess
import sys
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


@pytest.mark.parametrize("kind", ["errors", "kills"])
def test_every_writer_survives_all_of_it(tmp_path, kind):
    video = ("mp4",) if importlib.util.find_spec("cv2") else ()
    writers = ("csv", "robot", "removed robot", *thorough(("trace", "rotated robot", *video), ()))
    survived(tmp_path, kind, *writers)
