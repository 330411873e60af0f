"""Runs in threads of their own, for the tests."""

import contextlib
import threading
import time


@contextlib.contextmanager
def in_thread(work):
    """Do `work` in another thread inside the context; what it raises is raised at the end."""
    errors = []

    def guarded():
        try:
            work()
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=guarded, daemon=True)
    thread.start()
    try:
        yield thread
    finally:
        thread.join(300)
    assert not thread.is_alive()
    if errors:
        raise errors[0]


@contextlib.contextmanager
def running(sim, steps=10**8):
    """Let another thread run a simulation inside the context, and end the run with it."""
    before = sim.n_steps
    with in_thread(lambda: sim.run(steps)) as thread:
        while sim.n_steps == before and thread.is_alive():
            time.sleep(0)
        try:
            yield
        finally:
            assert sim.is_running, "the run was too short to test anything"
            sim.stop()


def together(*work):
    """Do all of it at the same time, each in a thread of its own; raise what one of them raised."""
    barrier = threading.Barrier(len(work))

    def after_all_have_come(do):
        barrier.wait()
        do()

    with contextlib.ExitStack() as stack:
        for do in work:
            stack.enter_context(in_thread(lambda do=do: after_all_have_come(do)))
