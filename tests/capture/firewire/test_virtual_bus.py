"""The virtual FireWire bus, in processes that are started with it.

Each file of `on_the_bus` is run by a pytest of its own, whose C library has the bus before it.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import surroundings
from doubles import with_bus_library
from surroundings import needs_double

pytestmark = [pytest.mark.slow, pytest.mark.sanitized]

CASES = sorted(Path(__file__).with_name("on_the_bus").glob("case_*.py"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_on_the_bus(case):
    needs_double("firewire")
    environment = {
        **os.environ,
        "LD_PRELOAD": with_bus_library(),
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
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
    assert surroundings.THREAD_SANITIZER or "skipped" not in run.stdout
