"""Waits for other threads, and the interpreter held from them."""

import ctypes
import time


def wait_for(condition, seconds=300):
    """Return what the condition says once it is true; fail if it takes too long."""
    end = time.monotonic() + seconds
    while not (result := condition()):
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.01)
    return result


#: s, one after the other: on a busy machine it may take long until other threads have their turn.
LONGER_AND_LONGER = (0.2, 1, 4, 16)


def keep_interpreter(seconds):
    ctypes.PyDLL(None).usleep(int(1e6 * seconds))
