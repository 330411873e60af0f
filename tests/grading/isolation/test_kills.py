"""Zygotes and workers that are killed at any moment: found, replaced, and nothing is left."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from robsim.grading._isolation import _process
from robsim.grading._isolation._processes import zygotes as _zygotes
from robsim.grading._isolation._processes.zygotes import close_zygotes

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux"),
    pytest.mark.long,
]

WAITS = "channel.sendall(b'x'); import time; time.sleep(600)"


def zygotes():
    return list(_zygotes._zygotes.values())


def gone(process):
    """Whether a process has ended, or is about to be reaped."""
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] in "ZX"


def wait_until(condition):
    deadline = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def children_of(process):
    children = Path(f"/proc/{process}/task/{process}/children").read_text()
    return [int(child) for child in children.split()]


def split(process):
    """The processes of a zygote, two where it is not root's, and its workers."""
    below = [split(child) for child in children_of(process)]
    if not below:
        return [], [process]
    own, workers = ([p for part in parts for p in part] for parts in zip(*below, strict=True))
    return [process, *own], workers


def test_a_killed_zygote_takes_its_workers_along_and_is_replaced(worker, ended):
    close_zygotes()
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        (zygote,) = zygotes()
        _, (process,) = split(zygote.process)
        os.kill(zygote.process, signal.SIGKILL)
        ending = started.wait(60)
        assert "the process that starts workers was killed" in ending.text
        wait_until(lambda: gone(process))
    base = zygote.base
    assert ended("print(1)")[1] == "1\n"
    assert not os.path.exists(base)
    (other,) = zygotes()
    assert other.process != zygote.process


def test_a_killed_worker_is_said(worker):
    close_zygotes()
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        (zygote,) = zygotes()
        _, (process,) = split(zygote.process)
        os.kill(process, signal.SIGKILL)
        assert started.wait(60).text == "its process was ended by signal SIGKILL"


def test_a_zygote_that_hangs_is_killed_and_replaced(worker, ended, monkeypatch):
    monkeypatch.setattr(_process, "_END", 0.2)
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        for zygote in zygotes():
            for process in split(zygote.process)[0]:
                os.kill(process, signal.SIGSTOP)
        started.kill()
        assert "the process that starts workers was killed" in started.wait().text
    assert ended("print(1)")[1] == "1\n"


def test_closing_ends_workers_and_folders(worker):
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        bases = [zygote.base for zygote in zygotes()]
        close_zygotes()
        assert started.wait(60).over
    assert not [base for base in bases if os.path.exists(base)]


def test_a_zygote_that_is_killed_while_it_ends_a_user_loses_no_user(ended, monkeypatch):
    from robsim.grading._isolation._layers import users

    user = users.take_user()
    if user is None:
        pytest.skip(users.reason())
    plain, killed = _zygotes.ZygoteProcess.end_user, []

    def end_user(zygote, number):
        if not killed:
            killed.append(zygote.process)
            os.kill(zygote.process, signal.SIGKILL)
            wait_until(lambda: gone(zygote.process))
        plain(zygote, number)

    monkeypatch.setattr(_zygotes.ZygoteProcess, "end_user", end_user)
    close_zygotes()
    _zygotes.lose_user(user)
    assert ended("print(1)")[1] == "1\n"
    assert killed
    assert user not in users._taken


GRADER = """
import os, socket, sys, threading
from robsim.grading._isolation import start_worker
from robsim.grading._isolation._processes import zygotes as _zygotes
ours, theirs = socket.socketpair()
worker = start_worker(entry="isolation_entry:run", channel=theirs, path=(sys.argv[1],))
theirs.close()
ours.sendall(b"channel.sendall(b'x'); import time; time.sleep(600)")
ours.recv(1)
(zygote,) = _zygotes._zygotes.values()
children = open(f"/proc/{zygote.process}/task/{zygote.process}/children").read()
print(zygote.process, zygote.base, children, flush=True)
threading.Event().wait()
"""


def test_a_killed_grader_leaves_nothing(entries):
    command = [sys.executable, "-c", GRADER, entries]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as grader:
        zygote, base, *workers = grader.stdout.readline().split()
        assert workers
        grader.kill()
    wait_until(lambda: all(gone(process) for process in (zygote, *workers)))
    wait_until(lambda: not os.path.exists(base))


def test_a_forked_grader_has_zygotes_of_its_own(ended):
    ended("print(1)")
    before = [zygote.process for zygote in zygotes()]
    child = os.fork()
    if child == 0:
        os._exit(len(zygotes()))
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert [zygote.process for zygote in zygotes()] == before
    assert ended("print(2)")[1] == "2\n"


@pytest.mark.slow
def test_kills_at_random_moments(worker, rng):
    """Each worker gives its answer or says that it was lost; no run hangs, nothing is left."""
    stop = threading.Event()

    def kill():
        while not stop.wait(float(rng.uniform(0.05, 0.5))):
            with suppress(OSError):  # it is gone by itself
                targets = [zygote.process for zygote in zygotes()]
                targets = [p for target in targets for part in split(target) for p in part]
                if targets:
                    os.kill(int(rng.choice(targets)), signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    answers = []
    try:
        for _ in range(100):
            try:
                with worker("channel.sendall(b'x')") as (started, channel):
                    try:
                        answers.append(channel.recv(1))
                    except OSError:
                        answers.append(b"")
                    assert started.wait(60).over
            except BrokenPipeError:
                answers.append(b"")
    finally:
        stop.set()
        killer.join()
    assert answers.count(b"x") > 50
    close_zygotes()


@pytest.mark.slow
def test_three_hundred_runs_at_flat_memory(ended):
    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def opened():
        return len(os.listdir("/proc/self/fd"))

    ended("print(1)")
    before, files, (zygote, *_) = resident(), opened(), zygotes()
    wait_until(lambda: not os.listdir(zygote.base))
    held = len(os.listdir(f"/proc/{zygote.process}/fd")) + 1  # that of a worker which is just over
    for _ in range(300):
        ended("x = bytearray(10_000_000); print(len(x))")
    assert resident() - before < 20e6
    assert opened() == files
    wait_until(lambda: len(os.listdir(f"/proc/{zygote.process}/fd")) <= held)
    assert os.listdir(zygote.base) == []


def test_a_socket_that_is_held_keeps_nothing_alive(worker):
    """A grader that only closes its channel: the worker reads the end of it, and goes on."""
    with worker("channel.recv(1); print('the end')") as (started, channel):
        channel.shutdown(socket.SHUT_WR)
        assert started.wait(60).text == "its process ended by itself (exit code 0)"
    assert started.output == "the end\n"
