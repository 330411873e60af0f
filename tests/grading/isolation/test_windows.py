"""Workers on Windows: they are in a job object, are limited, end, and say what is missing."""

import os
import sys
import tempfile
import threading

import pytest

from robsim.grading import IsolationError, check_isolation

if sys.platform != "win32":
    pytest.skip("these are workers of Windows", allow_module_level=True)


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
        ("import os; os._exit(3)", "its process ended by itself (exit code 3)"),
        ("kept = []\nwhile True: kept.append(bytearray(1 << 24))", "1 GiB of memory"),
    ):
        ending, _ = ended(source)
        assert text in ending.text
        assert not ending.left


def test_what_it_writes_is_limited_and_removed(ended):
    source = (
        "import os, stat, time\n"
        "open('kept', 'wb').write(bytes(3 << 20)); os.chmod('kept', stat.S_IREAD)\n"
        "for _ in range(40): os.mkdir('folder'); os.chdir('folder')\n"
        "time.sleep(600)"
    )
    ending, _ = ended(source, folder_size=1 << 20)
    assert ending.text == "its process wrote more than 1 MiB of files, or folders too deep"
    assert not ending.left


def test_a_worker_that_runs_is_ended(worker):
    with worker("import time; print('x'); channel.sendall(b'x'); time.sleep(600)") as (w, end):
        end.recv(1)
        w.kill()
        assert w.wait().text == "its process was ended by the grader"
        assert w.output == "x\n"


def test_what_is_missing_is_said(worker):
    missing = "user, files, system calls, own process numbers, own network"
    expected = f"isolation: process, job object; not: {missing}"
    assert check_isolation().isolation_line == expected
    with pytest.raises(IsolationError, match="Windows"), worker("", isolation="strict"):
        pass
