"""Processes that die: nothing is lost, nothing is done twice, and only the guilty run fails."""

import contextlib
import os
import random
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import robsim
from campaign_code import deadly, final, run_of, slow_with_pid
from robsim.campaigns import campaign
from sizes import thorough
from waiting import wait_for

pytestmark = pytest.mark.slow

SCENARIO = robsim.Scenario(area=(300, 300), start="random", control=robsim.DriveAround())
OPTIONS = {"steps": 5, "seed": 1, "progress": False}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where the code of a campaign leaves its files."""
    monkeypatch.setenv("ROBSIM_TEST_FOLDER", str(tmp_path))
    return tmp_path


def test_a_run_that_always_kills_its_process_fails_and_no_other(folder):
    result = campaign(SCENARIO, metrics=[deadly, final], runs=60, executor=2, **OPTIONS)
    assert (folder / "killed").exists()
    assert np.flatnonzero(result.failed).tolist() == [33]
    assert result["error"][33].startswith("WorkerDied")
    others = np.delete(result["deadly"], 33)
    assert others.tolist() == [run for run in range(60) if run != 33]
    serial = campaign(SCENARIO, metrics=[deadly, final], runs=60, **OPTIONS)
    np.testing.assert_array_equal(*(np.delete(one["final_x"], 33) for one in (result, serial)))
    with pytest.raises(RuntimeError, match=r"run 33 .*WorkerDied"):  # it is not done here
        campaign(SCENARIO, metrics=[deadly], runs=35, executor=1, on_error="raise", **OPTIONS)


def pids(folder):
    return [int(file.stem) for file in folder.glob("*.pid")]


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    # A child that nobody has asked for is no process any more.
    status = Path(f"/proc/{pid}/stat")
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] != "Z"


def test_processes_killed_at_random_moments_lose_and_double_nothing(folder):
    n_kills, runs = thorough(10, 3), thorough(1000, 150)
    done, rng, killed = threading.Event(), random.Random(1), []

    def worker():
        alive = (pid for pid in pids(folder) if pid not in killed and is_alive(pid))
        return done.is_set() or next((pid for pid in alive if pid != os.getpid()), None)

    def kill():
        while len(killed) < n_kills and (pid := wait_for(worker)) is not True:
            done.wait(rng.uniform(0, 0.3))
            killed.append(pid)
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        (folder / "go").touch()

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        result = campaign(
            SCENARIO,
            metrics=[slow_with_pid, final],
            runs=runs,
            executor=2,
            store=folder / "store.sqlite",
            **OPTIONS,
        )
    finally:
        done.set()
        killer.join()
    assert killed
    # A run that is in hand at two of the kills is taken for their cause.
    failed = np.flatnonzero(result.failed)
    assert len(failed) <= n_kills // 2
    assert all(result["error"][run].startswith("WorkerDied") for run in failed)
    serial = campaign(SCENARIO, metrics=[final], runs=runs, **OPTIONS)
    for name, expected in (("slow_with_pid", np.arange(runs)), ("final_x", serial["final_x"])):
        np.testing.assert_array_equal(np.delete(result[name], failed), np.delete(expected, failed))


PROGRAM = """
import signal

import robsim
from campaign_code import slow_with_pid
from robsim.campaigns import campaign

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    scenario = robsim.Scenario(area=(300, 300))
    campaign(scenario, metrics=[slow_with_pid], runs=100000, steps=5, executor=2, progress=False)
"""


def environment():
    """That of a program which can import the code of campaigns."""
    support = str(Path(__file__).parents[1] / "support")
    path = os.pathsep.join([support, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": path}


def begun(folder):
    """A program with a campaign, and the numbers of its two processes."""
    program = folder / "program.py"
    program.write_text(PROGRAM)
    parent = subprocess.Popen(
        [sys.executable, program],
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_for(lambda: len(pids(folder)) == 2 or parent.poll() is not None)
    assert parent.poll() is None, parent.stderr.read()
    return parent, pids(folder)


def wait_until_gone(processes):
    wait_for(lambda: not any(map(is_alive, processes)))


def test_processes_end_with_their_parent_and_leave_nothing(folder, monkeypatch):
    (folder / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(folder / "temporary"))
    parent, processes = begun(folder)
    parent.kill()
    parent.communicate()
    wait_until_gone(processes)
    assert not list((folder / "temporary").iterdir())


def test_ctrl_c_ends_all_and_says_how_to_go_on(folder):
    parent, processes = begun(folder)
    os.killpg(parent.pid, signal.SIGINT)  # as a terminal does
    _, errors = parent.communicate()
    wait_until_gone(processes)
    assert errors.count("Traceback") == 1
    assert "store=FILE" in errors.splitlines()[-1]


UNGUARDED = """
import robsim
from robsim.campaigns import campaign

campaign(robsim.Scenario(area=(300, 300)), metrics="tracking", runs=9, steps=5, executor=2)
"""


def test_a_program_without_a_main_guard_gets_one_error(folder):
    (folder / "program.py").write_text(UNGUARDED)
    command = [sys.executable, folder / "program.py"]
    ended = subprocess.run(command, env=environment(), capture_output=True, text=True)
    assert ended.returncode == 1
    assert ended.stderr.count("Traceback") == 1
    assert "if __name__ == '__main__'" in ended.stderr


KILLED = """
import sys
import robsim
from campaign_code import final, slow_with_pid
from robsim.campaigns import campaign

if __name__ == "__main__":
    scenario = robsim.Scenario(area=(300, 300), start="random")
    metrics = [slow_with_pid, final]
    options = {"runs": 100, "steps": 5, "seed": 1, "executor": 2, "progress": False}
    print(campaign(scenario, metrics=metrics, store=sys.argv[1], **options).checksum)
"""


def test_a_program_killed_at_random_moments_comes_to_its_end(folder):
    (folder / "program.py").write_text(KILLED)
    (folder / "go").touch()
    command = [sys.executable, folder / "program.py", folder / "store.sqlite"]
    rng, rows, n_kills = random.Random(2), 0, thorough(6, 2)
    for n in range(n_kills + 1):
        before = len(pids(folder))
        program = subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, text=True)
        if n < n_kills:
            wait_for(lambda n=before, run=program: len(pids(folder)) > n or run.poll() is not None)
            time.sleep(rng.uniform(0, 0.3))
            program.kill()
        printed, _ = program.communicate()
        with contextlib.closing(sqlite3.connect(folder / "store.sqlite")) as database:
            exists = "SELECT count(*) FROM sqlite_master WHERE name = 'runs'"
            if database.execute(exists).fetchone()[0]:
                (now,) = database.execute("SELECT count(*) FROM runs").fetchone()
                assert rows <= now <= 100
                rows = now
    assert program.returncode == 0
    scenario = robsim.Scenario(area=(300, 300), start="random")
    metrics = {"slow_with_pid": run_of, "final": final}
    serial = campaign(scenario, metrics=metrics, runs=100, **OPTIONS)
    assert printed.strip() == serial.checksum


def test_processes_that_cannot_begin_are_told(folder):
    program = folder / "program.py"
    program.write_text(
        "from campaign_code import final\nfrom robsim.campaigns import campaign\n"
        "campaign(metrics=[final], runs=2, steps=2, executor=1, progress=False)\n"
    )
    ended = subprocess.run(
        [sys.executable, program],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 1
    assert "ended at their start" in ended.stderr
