"""Workers: their start, their limits and their end."""

import os
import sys

import pytest

from graded import layer
from red_team.ground import descendants
from robsim.teach import WorkerLimits
from sizes import thorough

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux")


# --- start and limits


@pytest.mark.long
def test_the_entry_gets_the_channel_and_the_memory(worker):
    memory = os.memfd_create("frames")
    os.write(memory, b"pixels")
    source = "import os; channel.sendall(b'%d ' % len(memory) + os.pread(memory[0], 9, 0))"
    for isolation in ("none", "process", "auto"):
        with worker(source, isolation=isolation, memory=[memory]) as (started, channel):
            assert channel.recv(99) == b"1 pixels"
            assert started.wait(300).text == "its process exited (exit code 0)"
            assert channel.recv(99) == b""
    os.close(memory)


@pytest.mark.long
def test_how_a_worker_ended_is_said_in_words(ended):
    for source, text in (
        ("raise SystemExit(3)", "its process exited (exit code 3)"),
        ("import os; os._exit(0)", "its process exited (exit code 0)"),
        ("import os; os._exit(70)", "its process exited"),
        ("import os; os._exit(71)", "(exit code 71)"),
        ("import builtins\nbuiltins.isinstance = lambda *a: True\n1 / 0", "its process exited"),
        ("1 / 0", "its process exited (exit code 1)"),
        ("import ctypes; ctypes.string_at(0)", "its process was ended by signal SIGSEGV"),
        ("bytearray(2 << 30)", "more than 1 GiB of memory"),
    ):
        ending, _ = ended(source)
        assert text in ending.text
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
    assert ending.text == "its process exited (exit code 0)"
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
        assert getattr(WorkerLimits(**{name: value}), name) == value
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            WorkerLimits(**{name: value - 1})
    for name in ("call", "first_call", "run", "cpu"):
        WorkerLimits(**{name: 1e6})
        for value in (0.0, 1.1e6):
            with pytest.raises(ValueError, match=rf"\b{name}\b"):
                WorkerLimits(**{name: value})


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


# --- the end


CALLS, FILES, PIDS, USER = layer.CALLS, layer.FILES, layer.PIDS, layer.USER


def is_gone(scratch):
    """With own mounts, a worker's folder has the name of the one that all of them lie in."""
    return not os.path.exists(scratch) or not os.listdir(scratch)


# Layers that are left out, so that each of the others has to hold alone. With all that is left out
# in the last, processes of the worker are found by whose children they were.
WITHOUT = {
    "all layers": (),
    "by process numbers": (CALLS, USER),
    "by user": (CALLS, PIDS),
    "by search": (CALLS, PIDS, USER),
}

# Its parent ends, or stays, when it runs.
DAEMON = """
import os, signal, time
runs, told = os.pipe()
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            signal.signal(number, signal.SIG_IGN)
        channel.sendall(b"x")
        os.write(told, b"x")
        time.sleep(600)
    os._exit(0)
os.read(runs, 1)
time.sleep(600 if {stay} else 0)
"""

STOPPED = """
import os, signal
channel.sendall(b"x")
os.kill(os.getpid(), signal.SIGSTOP)
while True: pass
"""

BOMB = f"""
import os, time
for _ in range({thorough(200, 50)}):
    try:
        if os.fork() == 0:
            time.sleep(600)
    except OSError:
        break
channel.sendall(b"x")
time.sleep(600)
"""

THREADS = """
import threading, time
for _ in range(8): threading.Thread(target=time.sleep, args=(600,)).start()
channel.sendall(b"x")
"""


SOURCES = {
    "a daemon whose parent ends": DAEMON.format(stay=False),
    "a daemon": DAEMON.format(stay=True),
    "stopped": STOPPED,
    "many children": BOMB,
    "threads": THREADS,
}


@pytest.mark.long
@pytest.mark.parametrize("without", WITHOUT.values(), ids=WITHOUT)
def test_no_process_is_left(worker, ended, without):
    ended("pass", without=without)  # now its zygote runs
    before = descendants(with_zombies=False)
    for name, source in SOURCES.items():
        with worker(source, without=without) as (started, channel):
            answer = channel.recv(1)
            assert answer == b"x" or CALLS not in without, name
            if "ends" in name:
                started.wait(300)
            started.kill()
            ending = started.wait()
        assert ending.over
        assert not ending.left, name
        assert descendants(with_zombies=False) <= before, name


@pytest.mark.parametrize("without", [(), (CALLS,), (CALLS, FILES)], ids=["", "files", "user"])
def test_no_file_is_left(ended, without, tmp_path):
    source = f"""
import os
for folder in ("/dev/shm", "/tmp", "/var/tmp", {str(tmp_path)!r}):
    try:
        open(os.path.join(folder, "left-by-a-worker-{os.getpid()}"), "w").close()
        print("left in", folder)
    except OSError as error:
        pass
os.makedirs("a/b"); open("a/b/c", "w").write("c")
os.symlink("/etc", "a/etc") if {CALLS in without and FILES in without} else None
os.chmod("a", 0) if {CALLS in without} else None
print(os.getcwd())
"""
    ending, output = ended(source, without=without)
    assert ending.text.endswith("(exit code 0)"), output
    *left, scratch = output.splitlines()
    assert is_gone(scratch)
    assert os.path.isdir("/etc")
    mine = f"left-by-a-worker-{os.getpid()}"
    if FILES in without:  # where there are no mounts either, these folders are open to all
        for line in left:
            os.remove(os.path.join(line.removeprefix("left in "), mine))
    else:
        assert not left


@pytest.mark.long
@pytest.mark.parametrize("stays", [False, True], ids=["ends", "stays"])
def test_deep_folders_are_removed_and_counted(ended, stays):
    source = f"""
import os, time
print(os.getcwd())
for _ in range(2100):
    os.mkdir("d"); os.chdir("d")  # deeper than a path may be long
open("file", "w").close(); os.mkdir("e"); os.mkdir("f")
time.sleep(600 if {stays} else 0)
"""
    ending, output = ended(source, folder_size=1 << 30)
    assert is_gone(output.strip())
    assert not ending.left
    if stays:
        assert ending.text == "its process wrote more than 1 GiB of files, or folders too deep"
    assert ended("print(1)")[1] == "1\n"
