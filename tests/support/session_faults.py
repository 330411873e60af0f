"""A recorder whose calls to the system fail in turn, or whose process is killed there.

A program of its own, started with faults.c preloaded: ``python session_faults.py FOLDER errors`` or
``kills``. It prints what was tried, or raises an AssertionError.
"""

import errno
import itertools
import sys
import tempfile
import warnings
from pathlib import Path

import faults
import sessions
from robsim.trace import Session
from robsim.trace.sessions._file import session_file
from sizes import thorough

STEPS = 2


def record(folder):
    """Record a short session; return what the writer says of it at the end."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sessions.record(folder, STEPS).close()
    return " ".join(str(warning.message) for warning in caught)


def check(folder, call, *, is_told):
    """What was written must be read, and be the steps that were recorded."""
    try:
        session = Session(folder)
    except (FileNotFoundError, ValueError):  # before there was a set-up
        file = session_file(folder)
        assert not file.exists() or b"/robsim/steps" not in file.read_bytes(), call
        return
    pictures = sessions.check_agreement(session)
    if not is_told:
        assert session.is_complete, (call, session.problems)
    if session.is_complete:
        assert session.count == pictures == STEPS, (call, session.count, pictures)


def fail_each(parent, error):
    """Let each call fail once; return how many there were."""
    broken = faults.Faults()
    for number in itertools.count(1):
        folder, before = parent / f"{error} {number}", faults.descriptors()
        broken.arm(folder, number, error)
        told = ""
        try:
            told = record(folder)
        except OSError as caught:  # before the first step only
            told = str(caught)
            assert not session_file(folder).exists()
        call = broken.disarm()
        assert faults.descriptors() == before, (call, number)
        check(folder, call, is_told=bool(told))
        if not call:
            assert not told
            break
        # A disk without hard links gets its names in another way.
        assert told or call in (*faults.HARMLESS, "link"), (call, number)
    return number - 1


def kill_each(parent):
    """Kill a child at each call in turn; return how many there were."""
    broken = faults.Faults()
    for number in itertools.count(1):
        folder = parent / f"killed {number}"

        def work(folder=folder):
            assert not record(folder)

        was_killed = faults.killed_at(broken, folder, number, work)
        check(folder, number, is_told=was_killed)
        if not was_killed:
            break
    return number - 1


def main(parent, kind):
    folder = Path(tempfile.mkdtemp(dir=parent))
    sessions.driven()
    if kind == "kills":
        count = kill_each(folder)
    else:
        count = sum(
            fail_each(folder, e) for e in thorough((errno.ENOSPC, errno.EIO), (errno.ENOSPC,))
        )
    assert count > 2 * STEPS
    print(f"{kind}: {count}")


if __name__ == "__main__":
    main(*sys.argv[1:])
