"""Runs in threads and processes of their own, for the tests."""

import contextlib
import os
import sys
import threading
import time
import traceback
import warnings

import pytest

import surroundings


def forks(test):
    """Mark a test that forks beside threads."""
    there = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
    under = surroundings.ADDRESS_SANITIZER or surroundings.THREAD_SANITIZER
    return there(pytest.mark.skipif(under, reason="forks beside threads")(test))


def in_fork(look):
    """Let a forked process look around; what it raises is printed, and fails the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        code = 1
        try:
            look()
            code = 0
        except BaseException:
            traceback.print_exc(file=sys.__stderr__)
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0


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
        if errors:  # the cause of an error in the context, too
            raise errors[0]
    assert not thread.is_alive()


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
