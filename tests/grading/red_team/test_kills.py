"""Whole graded runs while workers, zygotes and graders are killed at random moments."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from graded import assert_same_trace
from red_team import HONEST
from red_team.ground import SCENARIO, ground, more_left
from robsim.grading import GradingError
from robsim.grading._isolation._processes import zygotes
from robsim.grading._isolation._processes.zygotes import close_zygotes

#: What is said of what was killed, by whose fault it is: of a worker nobody knows who did it.
KILLED = {
    "submission": r"(\w+ )?at (the start|step \d+): its process was ended by signal SIGKILL",
    "grader": "the worker was lost: the process that starts workers was killed"
    "|a worker was killed 5 times while it was started",
}

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux"),
    pytest.mark.slow,
]


@pytest.fixture
def place(tmp_path):
    with ground(tmp_path) as made:
        yield made
    close_zygotes()


def children_of(process):
    try:
        return [*map(int, Path(f"/proc/{process}/task/{process}/children").read_text().split())]
    except OSError:
        return []


def gone(process):
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] in "ZX"


def test_a_run_gives_its_bytes_or_says_what_was_killed(place, rng):
    first = place.outcome(HONEST).trace
    before = place.left()
    stop = threading.Event()

    def kill():
        while not stop.wait(float(rng.uniform(0.02, 0.3))):
            targets = [zygote.process for zygote in list(zygotes._zygotes.values())]
            targets += [child for target in targets for child in children_of(target)]
            if targets:
                with suppress(OSError):  # it is gone by itself
                    os.kill(int(rng.choice(targets)), signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    whole, said = 0, []
    try:
        for _ in range(30):
            submission = place.submission(HONEST)
            try:
                trace = submission.run(SCENARIO, steps=30, test="x")
            except GradingError as error:
                said.append((error.whose, str(error)))
            else:
                assert_same_trace(trace, first)
                whole += 1
    finally:
        stop.set()
        killer.join()
    assert whole > 5
    assert [(whose, text) for whose, text in said if not re.fullmatch(KILLED[whose], text)] == []
    assert_same_trace(place.outcome(HONEST).trace, first)
    # Those zygotes are others.
    assert more_left({**before, "of zygotes": []}, {**place.left(), "of zygotes": []}) == {}


GRADER = """
import sys
from pathlib import Path
from red_team import HONEST
from red_team.ground import ground
from robsim.grading._isolation._processes import zygotes
with ground(Path(sys.argv[1])) as place:
    while True:
        place.outcome(HONEST)
        (zygote,) = zygotes._zygotes.values()
        print(zygote.process, zygote.base, flush=True)
"""


def test_what_grader_and_zygote_leave_that_are_killed_together_the_next_grader_removes(tmp_path):
    support = str(Path(__file__).parents[2] / "support")
    scratch, folder = tmp_path / "scratch", tmp_path / "class"
    scratch.mkdir()
    folder.mkdir()
    environment = {**os.environ, "PYTHONPATH": support, "TMPDIR": str(scratch)}
    left = []
    for _ in range(2):
        command = [sys.executable, "-c", GRADER, str(folder)]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, env=environment
        ) as grader:
            zygote, base = grader.stdout.readline().split()
            assert os.listdir(scratch) == [os.path.basename(base)]
            assert base not in left
            processes = [*children_of(int(zygote)), int(zygote), grader.pid]
            os.kill(int(zygote), signal.SIGSTOP)
            grader.kill()
            os.kill(int(zygote), signal.SIGKILL)
        left.append(base)
        deadline = time.monotonic() + 30
        while not all(map(gone, processes)):
            assert time.monotonic() < deadline, processes
            time.sleep(0.02)
    assert os.path.exists(left[-1])


def test_a_grader_that_is_killed_at_any_moment_leaves_nothing(tmp_path, rng):
    support = str(Path(__file__).parents[2] / "support")
    command = [sys.executable, "-c", GRADER, str(tmp_path)]
    environment = {**os.environ, "PYTHONPATH": support}
    for _ in range(4):
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, env=environment
        ) as grader:
            zygote, base = grader.stdout.readline().split()
            time.sleep(float(rng.uniform(0, 0.3)))
            processes = [int(zygote), *children_of(int(zygote))]
            grader.kill()
        deadline = time.monotonic() + 30
        while os.path.exists(base) or not all(map(gone, processes)):
            assert time.monotonic() < deadline, (processes, base)
            time.sleep(0.02)
