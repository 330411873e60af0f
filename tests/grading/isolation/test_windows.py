"""Workers on Windows: they are in a job object, are limited, end, and say what is missing."""

import ctypes
import os
import sys
import tempfile
import threading

import pytest

from robsim.grading import IsolationError, check_isolation

if sys.platform != "win32":
    pytest.skip("these are workers of Windows", allow_module_level=True)

from robsim.grading._isolation._processes.windows import scratch

# Which says that limits of a job hold, and does not keep them.
WINE = hasattr(ctypes.WinDLL("ntdll"), "wine_get_version")
wants_windows = pytest.mark.skipif(WINE, reason="Wine does not keep these limits")


@pytest.fixture(autouse=True)
def _nothing_is_left():
    yield
    for thread in threading.enumerate():
        if thread.name == "robsim keeper":
            thread.join(300)
            assert not thread.is_alive()
    assert not [n for n in os.listdir(tempfile.gettempdir()) if n.startswith("robsim-grading-")]


def test_how_a_worker_ended_is_said_in_words(ended):
    for source, text in (
        ("pass", "its process ended by itself (exit code 0)"),
        ("import os; os._exit(3)", "its process ended by itself (exit code 3)"),
        ("1/0", "its process ended by itself (exit code 1)"),
        ("raise MemoryError", "its process asked for more than 1 GiB of memory"),
        ("kept = []\nwhile True: kept.append(bytearray(1 << 24))", "1 GiB of memory"),
    ):
        ending, _ = ended(source)
        assert text in ending.text
        assert ending.max_rss > 1 << 20
        assert not ending.left


def test_a_worker_is_at_home_in_its_folder(ended, monkeypatch):
    monkeypatch.setenv("SECRET", "of the grader")
    names = "HOME", "USERPROFILE", "TEMP"
    ending, output = ended(
        "import os\n"
        f"homes = {{os.environ[name] for name in {names}}}\n"
        "print(homes == {os.getcwd()}, 'SECRET' in os.environ)"
    )
    assert output == "True False\n"
    assert ending.text == "its process ended by itself (exit code 0)"


def test_output_is_cut_and_the_rest_dropped(ended):
    ending, output = ended("for _ in range(300): print('x' * 10000)", output=1 << 10)
    assert output == "x" * 1024 + "\n... cut after 1 KiB"
    assert ending.text == "its process ended by itself (exit code 0)"


def test_all_files_together_are_limited(ended):
    ending, _ = ended(
        "import time\nopen('big', 'wb').write(bytes(3 << 20))\ntime.sleep(600)",
        folder_size=1 << 20,
    )
    assert ending.text == "its process wrote more than 1 MiB of files, or folders too deep"
    assert not ending.left


def test_files_that_are_read_only_or_lie_deep_are_removed(ended):
    ending, _ = ended(
        "import os, stat\n"
        "open('kept', 'w').close(); os.chmod('kept', stat.S_IREAD)\n"
        "for _ in range(40): os.mkdir('folder'); os.chdir('folder')"
    )
    assert ending.text == "its process ended by itself (exit code 0)"
    assert not ending.left


def test_a_worker_that_runs_is_ended(worker):
    with worker("import time; print('x'); channel.sendall(b'x'); time.sleep(600)") as (
        started,
        end,
    ):
        end.recv(1)
        assert not started.wait(0).over
        started.kill()
        assert started.wait().text == "its process was ended by the grader"
        assert started.output == "x\n"


CHILD = """
import subprocess, sys
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(6000)"])
"""


def test_what_a_worker_has_started_ends_with_it(ended):
    """Under Wine, which lets it start something: there its end is waited for, too."""
    ending, output = ended(CHILD)
    if WINE:
        assert ending.text == "its process ended by itself (exit code 0)"
    else:
        assert "OSError" in output


@wants_windows
def test_processor_time_is_limited_and_counted(ended):
    ending, _ = ended("while True: pass", cpu=1)
    assert ending.text == "its process used more than 1 s of processor time"
    assert ending.cpu_seconds > 0.5


@wants_windows
def test_no_memory_is_an_exception_in_the_worker(ended):
    _, output = ended("try: bytearray(2 << 30)\nexcept MemoryError: print('none')")
    assert output == "none\n"


def test_a_folder_that_nobody_holds_is_removed(tmp_path):
    (tmp_path / "robsim-grading-0" / "inner").mkdir(parents=True)
    (tmp_path / "robsim-grading-1").mkdir()
    (tmp_path / "other").mkdir()
    with (tmp_path / "robsim-grading-1.held").open("w"):
        scratch.remove_leftovers(str(tmp_path))
    assert sorted(os.listdir(tmp_path)) == ["other", "robsim-grading-1", "robsim-grading-1.held"]


def test_what_is_missing_is_said(worker):
    report = check_isolation()
    missing = "user, files, system calls, own process numbers, own network"
    assert report.isolation_line == f"isolation: process, job object; not: {missing}"
    assert not report.attempts["read a file"][0]
    assert not report
    with (
        pytest.raises(IsolationError, match="Windows"),
        worker("", isolation="strict"),
    ):
        pass
