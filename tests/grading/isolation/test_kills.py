"""Graders, zygotes and workers that are killed at any moment: told, and nothing is left."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

import graded
from graded import assert_same_trace
from red_team import HONEST
from red_team.ground import SCENARIO, ground, more_left
from robsim.teach import GradingError
from sizes import thorough
from waiting import wait_for

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux"),
    pytest.mark.long,
]

WAITS = "channel.sendall(b'x'); import time; time.sleep(600)"

#: What is said of what was killed, by whose fault it is: of a worker nobody knows who did it.
KILLED = {
    "submission": r"(\w+ )?at (the start|step \d+): its process was ended by signal SIGKILL",
    "grader": "the worker was lost: the process that starts workers was killed"
    "|a worker was killed 5 times during its start",
}


def zygotes():
    return list(graded.zygotes._zygotes.values())


def gone(process):
    """Whether a process has ended, or is about to be reaped."""
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] in "ZX"


def children_of(process):
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:
        return []
    return [int(child) for child in children.split()]


def wait_until_gone(processes, base=None):
    wait_for(lambda: all(map(gone, processes)) and not (base and os.path.exists(base)))


def split(process):
    """The processes of a zygote, two where it is not root's, and its workers."""
    below = [split(child) for child in children_of(process)]
    if not below:
        return [], [process]
    own, workers = ([p for part in parts for p in part] for parts in zip(*below, strict=True))
    return [process, *own], workers


def test_a_killed_worker_is_said_and_a_killed_zygote_takes_its_workers_along(worker, ended):
    graded.zygotes.close_zygotes()
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        (zygote,) = zygotes()
        _, (process,) = split(zygote.process)
        os.kill(process, signal.SIGKILL)
        assert started.wait(300).text == "its process was ended by signal SIGKILL"
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        _, workers = split(zygote.process)
        os.kill(zygote.process, signal.SIGKILL)
        ending = started.wait(300)
        assert "the process that starts workers was killed" in ending.text
        wait_until_gone(workers)
    assert ended("print(1)")[1] == "1\n"
    assert not os.path.exists(zygote.base)
    (other,) = zygotes()
    assert other.process != zygote.process


def test_a_zygote_that_hangs_is_killed_and_replaced(worker, ended, monkeypatch):
    monkeypatch.setattr("robsim.teach.isolation._process._END", 0.2)
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        for zygote in zygotes():
            for process in split(zygote.process)[0]:
                os.kill(process, signal.SIGSTOP)
        started.kill()
        assert "the process that starts workers was killed" in started.wait().text
    assert ended("print(1)")[1] == "1\n"


def test_closing_ends_workers_and_folders_and_a_fork_has_zygotes_of_its_own(worker):
    with worker(WAITS) as (started, channel):
        channel.recv(1)
        before = [zygote.process for zygote in zygotes()]
        bases = [zygote.base for zygote in zygotes()]
        child = os.fork()
        if child == 0:
            os._exit(len(zygotes()))
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert [zygote.process for zygote in zygotes()] == before
        graded.zygotes.close_zygotes()
        assert started.wait(300).over
    assert not [base for base in bases if os.path.exists(base)]


def test_a_zygote_that_is_killed_while_it_ends_a_user_loses_no_user(ended, monkeypatch):
    users = graded.users
    user = users.take_user()
    if user is None:
        pytest.skip(users.reason())
    plain, killed = graded.zygotes.ZygoteProcess.end_user, []

    def end_user(zygote, number):
        if not killed:
            killed.append(zygote.process)
            os.kill(zygote.process, signal.SIGKILL)
            wait_for(lambda: gone(zygote.process))
        plain(zygote, number)

    monkeypatch.setattr(graded.zygotes.ZygoteProcess, "end_user", end_user)
    graded.zygotes.close_zygotes()
    graded.zygotes.lose_user(user)
    assert ended("print(1)")[1] == "1\n"
    assert killed
    assert user not in users._taken


def test_a_socket_that_is_held_keeps_nothing_alive(worker):
    """A grader that only closes its channel: the worker reads the end of it, and goes on."""
    with worker("channel.recv(1); print('the end')") as (started, channel):
        channel.shutdown(socket.SHUT_WR)
        assert started.wait(300).text == "its process exited (exit code 0)"
    assert started.output == "the end\n"


@pytest.mark.slow
@pytest.mark.usefixtures("patient_grader")
def test_a_run_gives_its_bytes_or_says_what_was_killed(tmp_path, rng):
    """A run beside which nothing is killed is whole, whatever was killed before."""

    def kill(moment, choice):
        time.sleep(moment)
        targets = [zygote.process for zygote in zygotes()]
        targets += [child for target in targets for child in children_of(target)]
        if targets:
            with suppress(OSError):  # it is gone by itself
                os.kill(targets[int(choice * len(targets))], signal.SIGKILL)

    with ground(tmp_path) as place:
        first = place.outcome(HONEST).trace
        before, said = place.left(), []
        for number in range(thorough(40, 12)):
            killer = threading.Thread(target=kill, args=(rng.uniform(0, 0.15), rng.random()))
            if number % 2:
                killer.start()
            try:
                trace = place.submission(HONEST).run(SCENARIO, steps=30, test="x")
            except GradingError as error:
                said.append((number % 2, error.whose, str(error)))
            else:
                assert_same_trace(trace, first)
            if number % 2:
                killer.join()
        for killed, whose, text in said:
            assert killed, text
            assert re.fullmatch(KILLED[whose], text), text
        assert_same_trace(place.outcome(HONEST).trace, first)
        # The zygotes are others. Each removes the folder of its last worker.
        wait_for(
            lambda: (
                more_left({**before, "of zygotes": []}, {**place.left(), "of zygotes": []}) == {}
            )
        )
    graded.zygotes.close_zygotes()


GRADER = """
import sys
from pathlib import Path
from red_team import HONEST
from red_team.ground import ground
from graded import zygotes
with ground(Path(sys.argv[1])) as place:
    while True:
        place.outcome(HONEST)
        (zygote,) = zygotes._zygotes.values()
        print(zygote.process, zygote.base, flush=True)
"""


def grader(folder, **environment):
    """A process that grades for ever; its zygote, and the folder of that."""
    support = str(Path(__file__).parents[2] / "support")
    started = subprocess.Popen(
        [sys.executable, "-c", GRADER, str(folder)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": support, **environment},
    )
    zygote, base = started.stdout.readline().split()
    return started, int(zygote), base


def test_a_grader_that_is_killed_at_any_moment_leaves_nothing(tmp_path, rng):
    for _ in range(thorough(4, 1)):
        started, zygote, base = grader(tmp_path)
        with started:
            time.sleep(float(rng.uniform(0, 0.3)))
            processes = [zygote, *children_of(zygote)]
            started.kill()
        wait_until_gone(processes, base)


@pytest.mark.slow
def test_what_grader_and_zygote_leave_that_are_killed_together_the_next_grader_removes(tmp_path):
    scratch, folder = tmp_path / "scratch", tmp_path / "class"
    scratch.mkdir()
    folder.mkdir()
    for _ in range(2):
        started, zygote, base = grader(folder, TMPDIR=str(scratch))
        with started:
            assert os.listdir(scratch) == [os.path.basename(base)]
            processes = [*children_of(zygote), zygote, started.pid]
            os.kill(zygote, signal.SIGSTOP)
            started.kill()
            os.kill(zygote, signal.SIGKILL)
        wait_until_gone(processes)
        assert os.path.exists(base)
