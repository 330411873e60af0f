"""Runs that are killed at random moments while they are recorded.

A program of its own: ``python killed_sessions.py FOLDER SEED COUNT``. It prints how many were
killed, at least COUNT and one that was long enough. It raises an AssertionError if one of them lost
more than the step under way, or a step that had waited for a second.
"""

import os
import signal
import sys
import time
import traceback
from pathlib import Path

import cv2  # noqa: F401 - what all children need
import numpy as np
from mcap.reader import make_reader

import sessions
from robsim.trace import Session
from robsim.trace.sessions._ros import STEPS
from waiting import wait_for

AT_ONCE = 5
LOST_AT_MOST = 1.0  # s


def run_on(folder, log, lossless, is_told):
    """Record steps until the end of the process; note each before it is added.

    With `is_told`, a step begins when the previous one is written.
    """
    writer = sessions.SessionWriter(folder, setup=sessions.SETUP, lossless=lossless)
    for k in range(10**6):
        os.write(log, f"{k} {time.monotonic()!r} {k * is_told}\n".encode())
        sessions.add(writer, k)
        if is_told:
            writer.flush()
        else:
            time.sleep(0.02)


def log_of(folder):
    return Path(f"{folder}.log")


def start(folder, lossless, is_told):
    log = os.open(log_of(folder), os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    child = os.fork()
    if child == 0:
        try:
            run_on(folder, log, lossless, is_told)
        except BaseException:
            traceback.print_exc()
        os._exit(1)
    os.close(log)
    return child


def check(folder, killed):
    """Compare what can be read with what the child noted before it was killed."""
    lines = log_of(folder).read_text().splitlines()
    noted = np.array([float(line.split()[1]) for line in lines])
    # A machine that is busy elsewhere lets the child stand still, its threads too.
    stood_still = np.diff([*noted, killed]).max()
    told = int(lines[-1].split()[2])
    must = max(told, int(np.sum(noted < killed - LOST_AT_MOST - stood_still)))
    os.utime(f"{folder}.mcap", (0, 0))  # no copy under way
    session = Session(folder)
    assert must <= session.count <= len(noted), (folder, must, session.count, len(noted))
    assert not session.is_complete
    with session.path.open("rb") as file:  # completed by now
        assert sum(1 for _ in make_reader(file).iter_messages(STEPS)) == session.count
    pictures = sessions.check_agreement(session)
    left_out = sum(bool(row.left_out) for row in session._rows)
    assert pictures + left_out == session.count, (folder, pictures, left_out, session.count)
    return must


def main(parent, seed, count):
    rng = np.random.default_rng(int(seed))
    sessions.driven()
    n_killed = must = 0
    while n_killed < int(count) or must == 0:
        folders = [Path(parent, f"run {n_killed + i}") for i in range(AT_ONCE)]
        children = [start(folder, i % 2 == 1, i < 4) for i, folder in enumerate(folders)]
        wait_for(lambda folders=folders: all(log_of(folder).stat().st_size for folder in folders))
        begin, killed = time.monotonic(), {}
        moments = sorted(zip(rng.uniform(0.3, 1.8, len(children)), children, folders, strict=True))
        for moment, child, folder in moments:
            time.sleep(max(0.0, begin + moment - time.monotonic()))
            killed[folder] = time.monotonic()
            os.kill(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            assert os.WIFSIGNALED(status)
        must += sum(check(folder, moment) for folder, moment in killed.items())
        n_killed += AT_ONCE
    print(f"{n_killed} killed, {must} steps had to be there")


if __name__ == "__main__":
    main(*sys.argv[1:])
