"""A small form of ``./run faults``: live runs with faults at random moments."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parents[1] / "support"
ROUNDS, SLACK = 40, 3  # s, by which a busy machine may be late


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc and terminals")
def test_whatever_goes_wrong_the_robot_stands():
    pytest.importorskip("serial")
    path = os.pathsep.join([str(SUPPORT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "live_faults", "--rounds", str(ROUNDS), "--slack", str(SLACK)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
