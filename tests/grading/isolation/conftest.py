import socket
import sys
import threading
from contextlib import contextmanager

import pytest

import graded
from robsim.teach import WorkerLimits
from robsim.teach import isolation as _isolation

MINUTES = 300.0  # s: nothing here waits for so long, on a busy machine neither


@pytest.fixture(scope="package")
def entries(tmp_path_factory):
    """A folder with the module of the tests' workers: they run what they are sent."""
    folder = tmp_path_factory.mktemp("entries")
    (folder / "isolation_entry.py").write_text(ENTRY)
    return str(folder)


ENTRY = """
def run(channel, memory):
    source = channel.recv(1 << 16).decode()
    exec(compile(source, "submission", "exec"), {"channel": channel, "memory": memory})
"""


@pytest.fixture(scope="package", autouse=True)
def _no_zygote_is_left():
    yield
    if sys.platform != "win32":
        graded.zygotes.close_zygotes()


@pytest.fixture
def worker(entries):
    """Start a worker that runs a source; gives it, and the grader's end of its channel."""

    @contextmanager
    def start(source, *, isolation="auto", memory=(), hidden=(), without=(), **limits):
        ours, theirs = socket.socketpair()
        with ours:
            with theirs:
                started = _isolation.start_worker(
                    entry="isolation_entry:run",
                    channel=theirs,
                    memory=memory,
                    isolation=isolation,
                    hidden=hidden,
                    without=without,
                    path=(entries,),
                    limits=WorkerLimits(**limits),
                )
            ours.settimeout(MINUTES)
            with started:
                ours.sendall(source.encode())
                yield started, ours

    return start


@pytest.fixture
def ended(worker):
    """Run a source in a worker; return how it ended, and what it printed."""

    def run(source, **options):
        with worker(source, **options) as (started, _):
            ending = started.wait(MINUTES)
        return ending, started.output

    return run


@pytest.fixture(autouse=True)
def _no_thread_is_left():
    yield
    assert not [t for t in threading.enumerate() if t.name == "robsim worker" and t.is_alive()]
