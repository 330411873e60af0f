"""A worker is started, does its work, is limited, and ends; how it ended is said in words."""

import os
import sys

import pytest

from robsim.teach import Limits

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux")


@pytest.mark.long
def test_the_entry_gets_the_channel_and_the_memory(worker):
    memory = os.memfd_create("frames")
    os.write(memory, b"pixels")
    source = "import os; channel.sendall(b'%d ' % len(memory) + os.pread(memory[0], 9, 0))"
    for isolation in ("none", "process", "auto"):
        with worker(source, isolation=isolation, memory=[memory]) as (started, channel):
            assert channel.recv(99) == b"1 pixels"
            assert started.wait(300).text == "its process ended by itself (exit code 0)"
            assert channel.recv(99) == b""
    os.close(memory)


@pytest.mark.long
def test_how_a_worker_ended_is_said_in_words(ended):
    for source, text in (
        ("raise SystemExit(3)", "its process ended by itself (exit code 3)"),
        ("import os; os._exit(0)", "its process ended by itself (exit code 0)"),
        ("1 / 0", "its process ended by itself (exit code 1)"),
        ("import ctypes; ctypes.string_at(0)", "its process was ended by signal SIGSEGV"),
        ("bytearray(2 << 30)", "its process asked for more than 1 GiB of memory"),
    ):
        ending, _ = ended(source)
        assert ending.text == text
        assert ending.max_rss > 1 << 20
        assert not ending.left


@pytest.mark.long
def test_processor_time_of_all_threads_is_limited_and_counted(ended):
    spin = """
import threading
def spin():
    while True: pass
for _ in range(3): threading.Thread(target=spin, daemon=True).start()
spin()
"""
    ending, _ = ended(spin, cpu=1)
    assert ending.text == "its process used more than 1 s of processor time"
    assert ending.cpu_seconds >= 0.5


def test_output_is_cut_and_the_rest_dropped(ended):
    ending, output = ended("for _ in range(300): print('x' * 9999)", output=1000)
    assert ending.text == "its process ended by itself (exit code 0)"
    assert output == "x" * 1000 + "\n... cut after 1000 bytes"


@pytest.mark.long
def test_all_files_together_are_limited(ended):
    source = """
import time
for number in range(400): open(str(number), "wb").write(bytes(10))
time.sleep(600)
"""
    ending, _ = ended(source, folder_size=1 << 20)
    assert ending.text == "its process wrote more than 1 MiB of files, or folders too deep"


def test_a_worker_that_runs_says_so_and_is_ended(worker):
    with worker("import time; print('here'); channel.sendall(b'x'); time.sleep(600)") as (
        w,
        channel,
    ):
        assert channel.recv(1) == b"x"
        assert not w.wait(0).over
        w.kill()
        assert w.wait(0).text == "its process was ended by the grader"
        assert w.output == "here\n"
        assert channel.recv(1) == b""
        w.kill()  # once more does no harm


def test_nothing_of_the_grader_is_in_a_worker(ended, monkeypatch):
    monkeypatch.setenv("ROBSIM_SECRET", "7")
    looks = "import os, sys; print(len(os.listdir('/dev/fd')), [*os.environ], sys.argv)"
    _, output = ended(looks, isolation="process")
    assert "ROBSIM_SECRET" not in output
    assert "['-c']" in output
    assert int(output.split()[0]) < 8


def test_limits_are_limited():
    least = {"memory": 64 << 20, "output": 0, "open_files": 16, "threads": 1, "submission_files": 1}
    for name, value in least.items():
        assert getattr(Limits(**{name: value}), name) == value
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            Limits(**{name: value - 1})
    for name in ("call", "first_call", "run", "cpu"):
        Limits(**{name: 1e6})
        for value in (0.0, 1.1e6):
            with pytest.raises(ValueError, match=rf"\b{name}\b"):
                Limits(**{name: value})


def test_another_isolation_is_refused(worker):
    with pytest.raises(ValueError, match="isolation"), worker("", isolation="Auto"):
        pass


def test_a_grader_may_have_many_files_open(ended):
    """Numbers of descriptors above those that select() takes."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < 1300:
        pytest.skip(f"at most {hard} files here")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 1300), hard))
    opened = [os.open(os.devnull, os.O_RDONLY) for _ in range(1100)]
    try:
        assert ended("print(1)")[1] == "1\n"
    finally:
        for number in opened:
            os.close(number)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
