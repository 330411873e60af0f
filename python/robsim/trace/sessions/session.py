"""The class `Session`: a recorded run, as frames for an `Experiment` and as a trace."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError

from robsim._core import ColorClass, Frame, MarkerLayout, Observation, PlaneMap, RobotModel
from robsim.base.checks import Floats
from robsim.base.files import as_path, content_of, open_file
from robsim.base.text import cut, one_line
from robsim.trace.columns import GROUPS
from robsim.trace.run_info import RunInfo
from robsim.trace.sessions._setup import FORMAT, Setup
from robsim.trace.sessions.rows import Row, columns_of
from robsim.trace.trace import Trace
from robsim.vision.imaging.images import MOST_PIXELS, frame_size, pixels_of

_UNKNOWN_DT = 0.2  # s, of a trace whose times tell nothing
_LONGEST_DT = 1e6  # s
_AT_REST = 10.0  # s, before a file that was cut off is completed
_ALWAYS = ("t", "u", "pose_measured", "interrupted")
_WHERE_KNOWN = ("t_arrival", "t_sent", "last_u")


class Session:
    """A recorded run in a file: an iterable of `Observation`, one for each step.

    An `Experiment` reruns the recorded run with other callbacks:
    ``robsim.Experiment(session, ...)``. Each observation has the frame, its time, and the input
    that the robot actually received since the previous step. So estimators see the recorded run,
    regardless of the new controller's outputs.

    A killed or unfinished run can be read up to the last written step: a kill loses only the last
    step. Opening a truncated file completes it, unless the file has changed in the last 10 s, since
    another program may be copying it.

    Parameters
    ----------
    path : path
        The file, with or without its suffix ``.mcap``. A folder recorded by an earlier version of
        robsim is also read.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    setup : dict
        The content of the set-up.
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
        The positions of the markers on the robot.
    model : RobotModel or None
        The model of the robot.
    size : tuple of int or None
        Width and height of the frames (px); None = no frames.
    count : int
        Number of steps.
    is_complete : bool
        Whether the recording was ended, and all its parts exist.
    problems : tuple of str
        The missing parts, a sentence each.
    trace : Trace
        Times, inputs and measured poses of the run; `full_trace` has the whole record.

    Raises
    ------
    FileNotFoundError
        If the file does not exist, or a folder has no session.
    TypeError, ValueError
        If the file is damaged, or is not a session. Also raised during iteration if a frame is
        damaged.

    Notes
    -----
    A session is an MCAP file of ROS 2 messages, which Foxglove and rosbag2 can open: pictures
    (``/camera/image/compressed``, ``/camera/camera_info``), poses with their covariance
    (``/pose_measured``, ``/pose_estimated``), voltages (``/u``), faults (``/diagnostics``), and
    coordinate frames (``/tf``, ``/tf_static``). Stamps are exposure times. Lengths are in m if the
    scale is known; otherwise they are in px, and the names of the coordinate frames end with
    ``_px``.

    In the coordinate frame ``area`` (the work area), x points right, y down and z into the floor;
    in ``map``, y and z point up. ``robot`` has the axes of the area, turned by the heading; in
    ``base_link`` z points up. ``camera`` is the optical frame of a camera with a calibrated lens.
    robsim itself reads the exact numbers in ``/robsim/steps``, and the set-up in the metadata
    ``robsim.setup``.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     trace = robsim.Experiment(camera, measure=True, record="monday").run(3)
    >>> session = robsim.trace.Session("monday")
    >>> len(session), session.size, session.is_complete
    (3, (1200, 1200), True)
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        from robsim.trace.sessions import _file, _folders  # mcap takes 30 ms

        self.path = as_path(path)
        is_folder = self.path.is_dir()
        if is_folder and not self._is_in(self.path):
            raise FileNotFoundError(
                f"{one_line(self.path)} has no session: the file {_folders.SETUP} is missing"
            )
        if not is_folder:
            self.path = _file.existing_file(self.path)
            with suppress(OSError, *_file.UNREADABLE):  # then it is read as it is
                _file.complete(self.path, _AT_REST)
        found = _folders.read_folder(self.path) if is_folder else _file.read_file(self.path)
        self._found = found
        source = self.path / _folders.SETUP if is_folder else self.path
        setup = Setup(found.setup, source, _folders.FORMAT if is_folder else FORMAT)
        self.setup = setup.table
        self.area, self.dt = setup.area, setup.dt
        self.plane_map = setup.plane_map or PlaneMap()
        self.mm_per_px: float | None = setup.mm_per_px
        self.colors: list[ColorClass] | None = setup.colors
        self.markers: MarkerLayout | None = setup.markers
        self.model: RobotModel | None = setup.model
        self._parsed = setup
        self._rows = found.rows
        self.count = len(self._rows)
        self.size: tuple[int, int] | None = None
        with self._opened() as file:
            seen = (self._pixels(k, file) for k, place in enumerate(found.places) if place)
            self.size = next((frame_size(pixels) for pixels in seen), None)
        self.problems = (*found.problems, *self._missing())
        self.is_complete = not self.problems
        self.trace = self._trace()

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Observation]:
        with self._opened() as file:
            for k in range(self.count):
                yield self._observation(k, file)

    @staticmethod
    def _is_in(path: Path) -> bool:
        """Whether a session exists, judged by a quick look."""
        from robsim.trace.sessions import _file, _folders

        path = _file.existing_file(path)
        if path.is_dir():
            return (path / _folders.SETUP).is_file()
        return path.is_file() and content_of(path, len(_file.MAGIC)) == _file.MAGIC

    def full_trace(self) -> Trace:
        """Return the complete record with estimates if the run ended normally, otherwise `trace`.

        Raises
        ------
        ValueError
            If the session is damaged.
        """
        if (place := self._found.trace) is None:
            return self.trace
        with open_file(self._found.trace_file) as file:
            return Trace._unpacked(
                self._found.encoded(file, place), one_line(self._found.trace_file)
            )

    def _opened(self) -> Any:
        """Return the file of the pictures, in a context."""
        return open_file(self._found.file) if any(self._found.places) else nullcontext(None)

    def _at(self, k: int) -> Observation:
        """Return the observation of a step, in any order; IndexError for an unknown step."""
        with self._opened() as file:
            return self._observation(k, file)

    def __repr__(self) -> str:
        size = f"frames of {self.size[0]} x {self.size[1]} px" if self.size else "no frames"
        missing = f", {len(self.problems)} problems" if self.problems else ""
        return f"<Session {one_line(self.path)}: {self.count} steps, {size}{missing}>"

    def _pixels(self, k: int, file: Any) -> Any:
        """Return RGB pixels (H, W, 3); ValueError: damaged, too large or of another size."""
        place = self._found.places[k]
        if place is None:
            return None
        try:
            with Image.open(
                io.BytesIO(self._found.encoded(file, place)), formats=("JPEG", "PNG")
            ) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    raise ValueError(f"it has {width} x {height} px, which are too many")
                if self.size not in (None, image.size):
                    raise ValueError(f"it has {width} x {height} px, unlike the first frame")
                return pixels_of(image, "RGB")
        except Exception as error:  # Pillow's decoders raise many types
            said = "no picture" if isinstance(error, UnidentifiedImageError) else cut(error)
            name = f"the frame of step {self._rows[k].k} of {one_line(self._found.file)}"
            raise ValueError(f"{name} is damaged: {said}") from error

    def _observation(self, k: int, file: Any) -> Observation:
        row, before, frame = self._rows[k], self._rows[k - 1] if k else None, None
        pixels = self._pixels(k, file)
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
        """Return the robot's input since the previous step; None = not known."""
        if not np.isnan(row.last_u).any():
            return row.last_u
        if row.interrupted and self._parsed.stop_input is not None:
            return self._parsed.stop_input
        if before is None or row.interrupted or np.isnan(before.u).any():
            return None
        return before.u

    def _missing(self) -> Iterator[str]:
        if self._found.steps not in (None, self.count):
            yield f"{self.count} of {self._found.steps} steps exist"
        if left_out := sum(bool(row.left_out) for row in self._rows):
            yield f"{left_out} frames were omitted: these steps have no frame"

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
            raise ValueError(f"{one_line(self.path)}: {cut(error)}") from error


def _typical_gap(t: Floats) -> float:
    gap = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    return gap if 0 < gap < _LONGEST_DT else _UNKNOWN_DT
