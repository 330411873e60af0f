"""The end of a child that is noticed, and its number kept: it is not reaped yet."""

from __future__ import annotations

import os
import select
import sys
from contextlib import closing, suppress

assert sys.platform != "win32"


def wait_for_end(process: int) -> None:
    """Wait until a child has ended, so that its number is its own until somebody reaps it."""
    if sys.platform == "darwin":  # which has waitid only for newer versions of Python
        event = select.kevent(
            process,
            select.KQ_FILTER_PROC,
            select.KQ_EV_ADD | select.KQ_EV_ONESHOT,
            select.KQ_NOTE_EXIT,
        )
        with closing(select.kqueue()) as queue, suppress(ProcessLookupError):  # it has ended
            queue.control([event], 1)
    else:
        os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)
