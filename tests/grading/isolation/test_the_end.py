"""Whatever a worker has done, nothing of it is left when it has ended."""

import os
import sys

import pytest

from graded import layer
from red_team.ground import descendants
from sizes import thorough

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux")

CALLS, FILES, PIDS, USER = layer.CALLS, layer.FILES, layer.PIDS, layer.USER

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
    assert not os.path.exists(scratch)
    assert os.path.isdir("/etc")
    mine = f"left-by-a-worker-{os.getpid()}"
    if FILES in without:  # nothing but Landlock closes the folders that are open to all
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
    assert not os.path.exists(output.strip())
    assert not ending.left
    if stays:
        assert ending.text == "its process wrote more than 1 GiB of files, or folders too deep"
    assert ended("print(1)")[1] == "1\n"
