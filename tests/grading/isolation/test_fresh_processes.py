"""Workers without a zygote, as on macOS: they start, are limited, end, and say what is missing."""

import sys
import threading

import pytest

from robsim.teach import IsolationError, check_isolation

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="not on Windows"),
    pytest.mark.long,
]


@pytest.fixture(autouse=True)
def _no_zygote(monkeypatch):
    monkeypatch.setattr("robsim.teach.isolation.start.HAS_ZYGOTE", False)
    yield
    for thread in threading.enumerate():
        if thread.name == "robsim keeper":
            thread.join(300)
            assert not thread.is_alive()


def test_a_fresh_worker_runs_is_limited_and_ends(ended):
    ending, output = ended("import os, resource; print(os.getcwd() == os.environ['HOME'])")
    assert output == "True\n"
    assert ending.text == "its process exited (exit code 0)"
    assert ending.max_rss > 1 << 20
    assert not ending.left


def test_a_fresh_worker_is_ended_with_what_is_in_its_group(worker):
    source = "import os, time; os.fork(); channel.sendall(b'x'); time.sleep(600)"
    with worker(source) as (started, channel):
        channel.recv(1)
        started.kill()
        assert started.wait().text == "its process was ended by the grader"
        while channel.recv(9):  # both have closed their ends
            pass


def test_what_is_missing_is_said(worker):
    report = check_isolation()
    assert not report
    missing = "own mounts, user, files, system calls, own process numbers, own network"
    assert f"not: {missing}" in report.isolation_line
    assert not report.certain_end
    with (
        pytest.raises(IsolationError, match="'strict'"),
        worker("", isolation="strict"),
    ):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="macOS limits no addresses")
def test_limits_hold_without_a_zygote(ended):
    ending, _ = ended("bytearray(2 << 30)")
    assert "more than 1 GiB of memory" in ending.text
