"""A small form of ``./run faults``: live runs with faults at random moments."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from needs import needs_double
from sizes import thorough

ROUNDS = thorough(range(0, 60, 3), range(0, 60, 5))
ROUNDS_ON_WIRES = thorough((17, 21, 24, 35, 52), (17, 24, 35))  # what goes wrong with cameras
SLACK = 100  # s, by which a busy machine may be late
FRAMES = thorough(10_000, 4000)


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc and terminals"),
]


def check(*words):
    path = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, "-m", *map(str, words)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_whatever_goes_wrong_the_robot_stands():
    pytest.importorskip("serial")
    check("live_faults", "--slack", SLACK, "--workers", 1, "--only", *ROUNDS)


def test_whatever_goes_wrong_with_a_bus_or_a_server_the_robot_stands():
    pytest.importorskip("serial")
    needs_double("firewire")
    needs_double("gige")
    check(
        *("live_faults", "--slack", SLACK, "--workers", 1, "--cameras", "firewire", "gige"),
        *("--only", *ROUNDS_ON_WIRES),
    )


def test_a_long_stream_needs_no_more_memory():
    check("live_faults.stream", "--frames", FRAMES)
