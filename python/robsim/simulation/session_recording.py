"""The session that records the steps of an `Experiment`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Detection, Measurement, RobotModel, Step
from robsim.base.checks import Floats
from robsim.base.text import one_line
from robsim.simulation.runner import Runner
from robsim.trace import Trace
from robsim.trace.sessions._file import session_file
from robsim.trace.sessions.rows import Row
from robsim.trace.sessions.writer import SessionWriter, check_is_free


class SessionRecording:
    """The session of an experiment, which begins with its first run, in a new file.

    FileExistsError: the file exists.
    """

    def __init__(self, path: Path, *, lossless: bool) -> None:
        self.path = session_file(path)
        check_is_free(self.path)
        self._lossless = lossless
        self._writer: SessionWriter | None = None
        self._is_over = False
        self._u_before: Floats = np.zeros(2)

    @property
    def has_begun(self) -> bool:
        """Whether the file has content."""
        return self._writer is not None

    @property
    def error(self) -> Exception | None:
        """The first error of disk or encoder; any thread may read this."""
        return None if self._writer is None else self._writer.error

    def begin(
        self, runner: Runner, model: RobotModel, more: Mapping[str, Any], *, is_live: bool
    ) -> None:
        """Write the set-up, unless it is written already; RuntimeError if the session is over."""
        if self._is_over:
            raise RuntimeError(
                f"the session {one_line(self.path)} is complete: make a new Experiment with "
                "another file for record"
            )
        if self._writer is not None:
            return
        setup = {
            "robot": runner.robot.name,
            "area": runner.area,
            "is_live": is_live,
            "dt": model.dt,
            "colors": runner.colors,
            "markers": runner.markers,
            "model": model,
            **more,
        }
        self._writer = SessionWriter(
            self.path, setup=setup, lossless=self._lossless, waits=not is_live
        )

    def add(
        self,
        step: Step,
        u: Floats | None,
        measured: Measurement | None,
        detection: Detection | None,
        t_arrival: float | None,
        t_sent: float | None,
        interrupted: bool,
    ) -> None:
        """Record a step."""
        assert self._writer is not None
        nobody_else_sent = np.array_equal(step.last_u, self._u_before)
        self._u_before = np.zeros(2) if u is None else u
        row = Row(
            k=step.k,
            t=step.t,
            t_arrival=math.nan if t_arrival is None else t_arrival,
            t_sent=math.nan if t_sent is None else t_sent,
            u=(math.nan, math.nan) if u is None else u,
            last_u=(math.nan, math.nan) if nobody_else_sent else step.last_u,
            pose_measured=(math.nan,) * 3 if measured is None else measured.pose,
            interrupted=interrupted,
            reason=(detection and detection.reason) or "",
            covariance=None if measured is None else measured.covariance,
            estimate=step.estimate,
        )
        self._writer.add(row, step.frame)

    def flush(self) -> None:
        """Wait until all steps are written."""
        if self._writer is not None:
            self._writer.flush()

    def close(self, trace: Trace) -> None:
        """Complete the session."""
        self._is_over = True
        if self._writer is not None:
            self._writer.close(trace)
