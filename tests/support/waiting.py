"""Waiting for what another thread does."""

import time


def wait_for(condition, seconds=300):
    """Return what the condition says once it is true; fail if it takes too long."""
    end = time.monotonic() + seconds
    while not (result := condition()):
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.01)
    return result
