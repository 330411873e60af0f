"""The line on the terminal that shows how a live run is going."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections import deque
from typing import Self

from robsim._core import detect
from robsim.base.text import one_line
from robsim.cli.live.sources import WatchedCamera
from robsim.simulation import Experiment
from robsim.trace import Trace

_PERIOD = 0.125  # s
_RATE_OVER = 16  # periods
_TO_START, _CLEAR = "\r", "\x1b[K"


class StatusLine:
    """Renews a line on a terminal, and ends the run when its time is over.

    Without a terminal it shows nothing.

    Parameters
    ----------
    experiment : Experiment
        The run.
    camera : WatchedCamera
        Its camera.
    seconds : float, optional
        How long after the first frame the run is ended (s). Default: never.
    """

    def __init__(
        self, experiment: Experiment, camera: WatchedCamera, seconds: float | None
    ) -> None:
        self._experiment, self._camera = experiment, camera
        self._seconds = math.inf if seconds is None else seconds
        self._is_shown = sys.stderr.isatty()
        self._grabbed: deque[tuple[float, int]] = deque(maxlen=_RATE_OVER)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="robsim status", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join()
        if self._is_shown:
            sys.stderr.write(_TO_START + _CLEAR)
            sys.stderr.flush()

    def _watch(self) -> None:
        start = None
        while not self._is_over.wait(_PERIOD):
            if not (trace := self._experiment.trace):
                continue
            start = time.monotonic() if start is None else start
            if time.monotonic() - start >= self._seconds:
                self._experiment.stop()
            if self._is_shown:
                width = os.get_terminal_size(sys.stderr.fileno()).columns - 1
                line = one_line(self.text(trace))[: max(width, 20)]
                sys.stderr.write(_TO_START + line + _CLEAR)
                sys.stderr.flush()

    def text(self, trace: Trace) -> str:
        """Return the line."""
        now, counts = time.monotonic(), self._camera.counts
        self._grabbed.append((now, counts.grabbed))
        (before, grabbed), frame = self._grabbed[0], self._camera.newest
        rate = (counts.grabbed - grabbed) / (now - before) if now > before else math.nan
        age = math.nan
        if frame is not None and frame.epoch is not None and frame.t is not None:
            age = now - (frame.epoch + frame.t)
        left, right = trace.u[-1]
        return (
            f"{trace.t[-1]:5.1f} s {rate:5.1f}/s  age {1e3 * age:3.0f} ms  "
            f"dropped {counts.dropped + counts.torn}  {self._seen(trace)}  "
            f"{left:+.2f} {right:+.2f} V"
        )

    def _seen(self, trace: Trace) -> str:
        """Return the measured pose, or why there is none."""
        x, y, heading = trace.pose_measured[-1]
        if not math.isnan(x):
            return f"x {x:4.0f} y {y:4.0f} {math.degrees(heading):+4.0f} deg"
        experiment, frame = self._experiment, self._camera.newest
        if frame is None:
            return "not seen"
        blobs = experiment.find_blobs(frame)
        found = detect(blobs, experiment.markers, plane_map=frame.plane_map, image=frame)
        return f"not seen{f': {found.reason}' if found.reason else ''}"
