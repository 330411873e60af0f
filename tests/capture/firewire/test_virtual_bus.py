"""The virtual FireWire bus, in processes that are started with it.

Each file of `on_the_bus` is run by a pytest of its own, whose C library has the bus before it.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import robsim
from needs import needs_extension

pytestmark = [pytest.mark.slow, pytest.mark.sanitized]

CASES = sorted(Path(__file__).with_name("on_the_bus").glob("case_*.py"))
LIBRARY = Path(robsim.__file__).parent / "preloaded" / "virtual_bus.so"


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_on_the_bus(case):
    needs_extension("firewire")
    before = os.environ.get("LD_PRELOAD", "").split()
    places = [str(Path(__file__).parents[2] / "support"), str(Path(robsim.__file__).parents[1])]
    environment = {
        **os.environ,
        "LD_PRELOAD": " ".join([*before, str(LIBRARY)]),  # a sanitizer comes first
        "PYTHONPATH": os.pathsep.join([*places, os.environ.get("PYTHONPATH", "")]),
    }
    arguments = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "", str(case)]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[3],
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert re.search(r"\d+ passed", run.stdout), run.stdout
    assert "skipped" not in run.stdout
