"""The class `Session`: a recorded run, as frames for an `Experiment` and as a trace."""

from __future__ import annotations

import math
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import ColorClass, Frame, MarkerLayout, Observation, PlaneMap, RobotModel
from robsim.base.checks import Floats
from robsim.base.files import as_path, codec
from robsim.base.text import cut, one_line, quoted
from robsim.trace.columns import GROUPS
from robsim.trace.run_info import RunInfo
from robsim.trace.sessions._pictures import Pictures
from robsim.trace.sessions._setup import Setup
from robsim.trace.sessions.rows import Row, columns_of, read_rows
from robsim.trace.sessions.writer import END, ROWS, SETUP, TRACE, VIDEO
from robsim.trace.trace import Trace

_UNKNOWN_DT = 0.2  # s, of a trace whose times tell nothing
_LONGEST_DT = 1e6  # s
_ALWAYS = ("t", "u", "pose_measured", "interrupted")
_WHERE_KNOWN = ("t_arrival", "t_sent", "last_u")


class Session:
    """A recorded run in a folder: an iterable of `Observation`, one for each step.

    An `Experiment` runs it again, with other callbacks: ``robsim.Experiment(session, ...)``. Each
    observation has the frame, its time, and the input that the robot really got since the step
    before, so that estimators see the run as it was, whatever the new controller returns.

    A run that was killed, or is still going on, can be read up to what was written when the session
    was opened: all but the last second.

    Parameters
    ----------
    folder : path
        The folder: ``setup.toml`` has the set-up, ``steps.csv`` a line for each step,
        ``frames.mkv`` the frames, which any player shows; ``end.toml`` and ``trace.npz`` are
        written at the end of the run.

    Attributes
    ----------
    folder : pathlib.Path
        The folder.
    setup : dict
        All that the set-up says.
    area : tuple of int or None
        Width and height of the work area (px).
    dt : float or None
        Sample time (s).
    plane_map : PlaneMap
        Map from frame pixels to the work area.
    mm_per_px : float or None
        Length of a px of the work area on the floor (mm), if the camera was calibrated.
    colors : list of ColorClass, or None
        The colours of the markers.
    markers : MarkerLayout or None
        Where the markers are on the robot.
    model : RobotModel or None
        The model of the robot.
    size : tuple of int or None
        Width and height of the frames (px); None = there are none.
    count : int
        Number of steps.
    is_complete : bool
        Whether the recording was ended, and all that belongs to it is there.
    problems : tuple of str
        What is missing, a sentence each.
    trace : Trace
        Times, inputs and measured poses of the run. ``robsim.Trace.load(folder / "trace.npz")`` has
        all that was recorded, if the run ended well.

    Raises
    ------
    FileNotFoundError
        If there is no such folder, or it has no session.
    TypeError, ValueError
        If a file of it is damaged. During iteration: if a frame is.

    Examples
    --------
    >>> session = robsim.trace.Session("monday")
    >>> again = robsim.Experiment(session, colors="other_colors.toml").run()
    >>> again.pose_measured - session.trace.pose_measured
    """

    def __init__(self, folder: str | PathLike[str]) -> None:
        self.folder = as_path(folder, "folder")
        if not self.folder.is_dir():
            raise FileNotFoundError(f"there is no folder {one_line(self.folder)}")
        if not self._is_in(self.folder):
            raise FileNotFoundError(f"{one_line(self.folder)} has no session: no file {SETUP}")
        setup = Setup(self.folder / SETUP)
        self.setup = setup.table
        self.area, self.dt = setup.area, setup.dt
        self.plane_map = setup.plane_map or PlaneMap()
        self.mm_per_px: float | None = setup.mm_per_px
        self.colors: list[ColorClass] | None = setup.colors
        self.markers: MarkerLayout | None = setup.markers
        self.model: RobotModel | None = setup.model
        self._parsed = setup
        # First the rows: while a run goes on, every row has its picture already.
        has_end = (self.folder / END).is_file()
        self._rows, self._torn_row = _rows_of(self.folder)
        self._pictures = _pictures_of(self.folder)
        self.count = len(self._rows)
        self.size = self._pictures.size if self._pictures else None
        self._check_numbers()
        self.problems = tuple(self._problems(has_end))
        self.is_complete = not self.problems
        self.trace = self._trace()

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Observation]:
        before = None
        if self._pictures is None:
            for row in self._rows:
                yield self._observation(row, before, None)
                before = row
            return
        with self._pictures.opened() as descriptor:
            for row in self._rows:
                pixels = None
                if self._has_picture(row):
                    assert row.video_frame is not None
                    pixels = self._pictures.read(descriptor, row.video_frame)
                yield self._observation(row, before, pixels)
                before = row

    @staticmethod
    def _is_in(folder: Path) -> bool:
        return (folder / SETUP).is_file()

    def _whole_trace(self) -> Trace:
        """Return all that was recorded, if the run ended well; else `trace`."""
        file = self.folder / TRACE
        return Trace.load(file) if file.is_file() else self.trace

    def _at(self, k: int) -> Observation:
        """Return the observation of a step, in any order; IndexError if there is none."""
        row, pixels = self._rows[k], None
        if self._pictures is not None and self._has_picture(row):
            assert row.video_frame is not None
            with self._pictures.opened() as descriptor:
                pixels = self._pictures.read(descriptor, row.video_frame)
        return self._observation(row, self._rows[k - 1] if k else None, pixels)

    def __repr__(self) -> str:
        size = f"frames of {self.size[0]} x {self.size[1]} px" if self.size else "no frames"
        missing = f", {len(self.problems)} problems" if self.problems else ""
        return f"<Session {one_line(self.folder)}: {self.count} steps, {size}{missing}>"

    def export_mcap(self, path: str | PathLike[str]) -> None:
        """Write the session as an MCAP file, for Foxglove and ROS 2.

        The topics: ``/camera/image/compressed`` (`sensor_msgs/msg/CompressedImage`, the pictures as
        they were recorded), ``/pose_measured`` (`geometry_msgs/msg/PoseStamped`, in px of the work
        area: x to the right, y down, z into the floor, in the frame ``area``; only where the robot
        was detected), ``/u`` (`std_msgs/msg/Float64MultiArray`, V) and ``/missed``
        (`std_msgs/msg/String`: why the robot was not detected). Their times are those of the
        frames, and of the inputs when they went out, from the date of the recording on.

        Parameters
        ----------
        path : path
            The file to write; by custom its name ends with ``.mcap``.

        Raises
        ------
        ImportError
            If the packages of ``robsim[mcap]`` are not installed.
        OSError
            If the file cannot be written; an old one of that name is unchanged then.
        """
        from robsim.trace.sessions._mcap import write_mcap

        write_mcap(path, self)

    def _has_picture(self, row: Row) -> bool:
        n = len(self._pictures) if self._pictures else 0
        return row.video_frame is not None and row.video_frame < n

    def _observation(self, row: Row, before: Row | None, pixels: Any) -> Observation:
        frame = None
        if pixels is not None:
            frame = Frame(
                pixels,
                copy=False,
                t=row.t,
                t_arrival=None if math.isnan(row.t_arrival) else row.t_arrival,
                index=row.frame_index or 0,
                plane_map=row.plane_map or self.plane_map,
                headings=row.headings,
            )
        return Observation(
            frame, t=row.t, last_u=self._last_u(row, before), interrupted=row.interrupted
        )

    def _last_u(self, row: Row, before: Row | None) -> Any:
        """Return the input that the robot got since the step before; None = not known."""
        if not np.isnan(row.last_u).any():
            return row.last_u
        if row.interrupted and self._parsed.stop_input is not None:
            return self._parsed.stop_input
        if before is None or row.interrupted or np.isnan(before.u).any():
            return None
        return before.u

    def _check_numbers(self) -> None:
        """Raise a ValueError if rows name pictures in another order than that of the video."""
        last = -1
        for row in self._rows:
            if row.video_frame is not None:
                if row.video_frame != last + 1:
                    raise ValueError(
                        f"{one_line(self.folder / ROWS)}: video_frame of step {row.k} must be "
                        f"{last + 1}, got {row.video_frame}"
                    )
                last = row.video_frame

    def _problems(self, has_end: bool) -> Iterator[str]:
        numbers = [row.video_frame for row in self._rows if row.video_frame is not None]
        there = len(self._pictures) if self._pictures else 0
        if not has_end:
            yield "the recording was not ended: it was killed, or is still going on"
        elif steps := self._steps_promised() - self.count:
            yield f"{ROWS} has {self.count} of {self.count + steps} steps"
        if self._torn_row:
            yield f"the last line of {ROWS} is torn: it is ignored"
        if self._pictures is not None and self._pictures.torn:
            yield f"the last picture of {VIDEO} is torn: it is ignored"
        if there > len(numbers):
            yield f"{there - len(numbers)} frames at the end have no row: they are ignored"
        if self._pictures is None and numbers:
            yield f"there is no {VIDEO}: no step has a frame"
        elif there < len(numbers):
            yield f"{VIDEO} has {there} of {len(numbers)} frames: the last steps have none"
        if left_out := sum(bool(row.left_out) for row in self._rows):
            yield f"{left_out} frames were left out of the video: these steps have none"

    def _steps_promised(self) -> int:
        file = self.folder / END
        end = codec.load_table(file)
        steps, lost = end.get("steps"), end.get("steps_lost", 0)
        if not (type(steps) is int and type(lost) is int and 0 <= steps + lost < 2**62):
            raise ValueError(f"{one_line(file)}: steps must be a whole number, got {quoted(steps)}")
        return steps + lost

    def _trace(self) -> Trace:
        groups: dict[str, Floats] = columns_of(self._rows, *_ALWAYS)
        drawn = {row.headings for row in self._rows if row.frame_index is not None}
        for name, values in columns_of(self._rows, *_WHERE_KNOWN).items():
            if name in GROUPS and np.isfinite(values).any():
                groups[name] = values
        try:
            info = RunInfo(
                dt=_typical_gap(groups["t"]) if self.dt is None else self.dt,
                theta_true=np.full((3, 5), np.nan),
                identify_from="measurement",
                area=self.area or self.size or (1200, 1200),
                boundary="recorded",
                robot=self._parsed.robot,
                marker_colors=(*self.markers.colors.values(),) if self.markers else (),
                mm_per_px=self.mm_per_px,
                headings=drawn.pop() if len(drawn) == 1 else None,
            )
            first = self._rows[0].k if self._rows else 0
            return Trace(groups, info, first_step=first)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{one_line(self.folder)}: {cut(error)}") from error


def _typical_gap(t: Floats) -> float:
    gap = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    return gap if 0 < gap < _LONGEST_DT else _UNKNOWN_DT


def _rows_of(folder: Path) -> tuple[list[Row], bool]:
    try:
        return read_rows(folder / ROWS)
    except FileNotFoundError:  # killed before the first step
        return [], False


def _pictures_of(folder: Path) -> Pictures | None:
    try:
        return Pictures(folder / VIDEO)
    except FileNotFoundError:
        return None
