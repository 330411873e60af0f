"""Recorded frames from a video file or a folder of images, for `Experiment`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from robsim._core import Frame, Observation, PlaneMap
from robsim.base.checks import Floats, check_float, check_int, check_kind, check_size
from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.base.warn import warn_user
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import as_calibration
from robsim.vision.imaging.images import (
    Pixels,
    check_same_size,
    frame_size,
    image_suffixes,
    load_image,
)
from robsim.vision.imaging.video_reader import VideoReader

_MOST_NAMED = 3  # pictures in a warning
_SHORTEST_DT, _LONGEST_DT = 1e-3, 1e6  # s; files without a frame rate often claim 1 ms or less
_MOST_HEADINGS = 2**31 - 1
_BORDER = 32  # points of each side of a frame that a lens bends


class Recording:
    """A video file or a folder of images as an iterable of frames; each iteration starts again.

    Iteration is in lock step: each frame is read on demand, and no frame is lost.
    ``robsim.Camera(file)`` plays it at its own rate, and drops frames not taken in time.

    Parameters
    ----------
    source : path
        A video file, or a folder of images in any format that Pillow reads, in natural order of
        their names (frame2 before frame10). Other files in the folder are ignored.
    plane_map : PlaneMap, optional
        Map from frame pixels to the work area. By default, the frames show exactly the whole area,
        seen vertically from above.
    area : tuple of int, optional
        Width and height of the work area (px). Default: the area of the calibration, or the part of
        the plane in the frames. Without a plane map, the default is the size of the frames.
    dt : float, optional
        Time between two frames (s), instead of the times of a video. Default: the times of the
        video; images in a folder have no times.
    calibration : Calibration or path, optional
        The camera's calibration, instead of `plane_map`. Frames of another size are refused.
    headings : int, optional
        Number of drawn headings of the robot, at whole pixels, as in a simulation; the covariances
        of measured poses then include their rounding. Default: the number stored in a video of
        robsim. In other videos and in images, any heading is possible.

    Attributes
    ----------
    source : pathlib.Path
        The file or folder.
    plane_map : PlaneMap
        Map from frame pixels to the work area.
    area : tuple of int
        Width and height of the work area (px).
    dt : float or None
        Time between two frames (s), longer by whole intervals where frames were lost. None if this
        time varies, or is not known, as for images in a folder; an `Experiment` then uses the dt of
        its model.
    size : tuple of int
        Width and height of the frames (px).
    count : int
        Number of frames, including damaged ones.
    calibration : Calibration or None
        The camera's calibration.
    headings : int or None
        Number of drawn headings of the robot; None = any, or not known.

    Raises
    ------
    FileNotFoundError
        If the file or folder does not exist.
    ImportError
        If the file is a video, and PyAV is not installed.
    TypeError, ValueError
        If an argument has the wrong type, or `dt` or `area` is not positive. If a folder has no
        images, no frame can be read, or the frame rate is implausible.

    Warns
    -----
    UserWarning
        At the end of an iteration: if damaged frames or frames of another size were omitted, or a
        video is truncated. An `Experiment` has a step without a frame for each omitted frame.

    Notes
    -----
    The times of a video come from its file, and start at the first frame. A frame that depends on a
    damaged frame may show traces of the damage. A frame of an interlaced video shows the field that
    was exposed first, and has this field's time. The filter yadif interpolates the other rows,
    which adds errors of 0.1 px and 0.3 degrees to a pose. Frames keep the sensor's order, also
    where viewers rotate a video or photo.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1)
    >>> robsim.vision.save_video("run.mkv", (sim.step().frame for _ in range(5)), fps=5)
    >>> recording = robsim.Recording("run.mkv")
    >>> [len(robsim.find_blobs(frame, robsim.load_colors())) for frame in recording]
    [2, 2, 2, 2, 2]
    """

    def __init__(
        self,
        source: str | PathLike[str],
        *,
        plane_map: PlaneMap | None = None,
        area: tuple[int, int] | None = None,
        dt: float | None = None,
        calibration: Calibration | str | PathLike[str] | None = None,
        headings: int | None = None,
    ) -> None:
        if isinstance(source, int) or re.match(r"/dev/|[a-z]{3,}:/", str(source)):
            raise ValueError(
                f"source must be a video file or a folder of images, got {quoted(source)}; pass "
                "the "
                "frames of a live camera to robsim.Experiment"
            )
        self.source = as_path(source, "source")
        check_kind("plane_map", plane_map, PlaneMap, or_none=True)
        if not self.source.exists():
            raise FileNotFoundError(f"there is no file or folder {one_line(self.source)}")
        self.calibration = as_calibration(calibration, plane_map)
        self._told = ""  # the last warning
        self._images = _Folder(self.source) if self.source.is_dir() else VideoReader(self.source)
        self.size = self._first_size()
        if self.calibration is not None:
            self.calibration.check_frames(self.size)
            plane_map, area = self.calibration.plane_map, area or self.calibration.area
        self.count = self._images.count
        self.dt: float | None
        if dt is None:
            self.dt, times = self._images.dt, self._images.times
            if self.dt is not None and not self.dt > _SHORTEST_DT:
                raise ValueError(
                    f"{one_line(self.source)} has an implausible time of {self.dt:g} s between two "
                    "frames: give the true time as dt (s)"
                )
        else:
            self.dt = check_float("dt", dt, "s", exclusive_minimum=0, maximum=_LONGEST_DT)
            times = np.asarray(self.dt * np.arange(self.count))
        self._times = times
        self.headings = (
            self._images.headings
            if headings is None
            else check_int("headings", headings, minimum=1, maximum=_MOST_HEADINGS)
        )
        if area is not None:
            self.area = check_size("area", area)
        else:
            self.area = self.size if plane_map is None else _area_seen(plane_map, self.size)
        self.plane_map = plane_map or PlaneMap.scaled(resolution=self.size, area=self.area)

    def __iter__(self) -> Iterator[Frame]:
        yield from (one for one in self._each() if isinstance(one, Frame))

    def _each(self) -> Iterator[Frame | Observation]:
        """Yield a step for each picture, without a frame for an unreadable picture."""
        unread: list[ValueError | None] = []
        for index, pixels in enumerate(self._images.read()):
            try:
                frame = self._frame(index, pixels)
            except ValueError as error:
                unread.append(error if len(unread) < _MOST_NAMED else None)
                yield Observation(t=self._time(index))
            else:
                yield frame
        told = "; ".join(filter(None, (self._images.shortage, left_out(unread, self.count))))
        if told != self._told:
            warn_user(told)
            self._told = told

    def _time(self, index: int) -> float | None:
        return None if self._times is None else float(self._times[index])

    def _frame(self, index: int, pixels: Pixels | ValueError) -> Frame:
        if isinstance(pixels, ValueError):
            raise pixels
        check_same_size(self._images.name(index), frame_size(pixels), self.size)
        t, headings = self._time(index), self.headings
        return Frame(pixels, t=t, index=index, plane_map=self.plane_map, headings=headings)

    def _at(self, index: int) -> Frame:
        """Return a frame, in any order; IndexError: a missing frame, ValueError: a damaged one."""
        return self._frame(index, self._images.at(index))

    def __repr__(self) -> str:
        width, height = self.size
        unknown = "no times" if self._times is None else "irregular times"
        dt = unknown if self.dt is None else f"dt = {self.dt:g} s"
        frames = f"{self.count} frames of {width} x {height} px"
        return f"<Recording {one_line(self.source)}: {frames}, {dt}>"

    def _first_size(self) -> tuple[int, int]:
        reason = None
        for picture in self._images.read():
            if not isinstance(picture, ValueError):
                return frame_size(picture)
            reason = reason or picture
        why = "" if reason is None else f" that can be read: {reason}"
        raise ValueError(f"{one_line(self.source)} has no frames{why}")


def left_out(unread: Sequence[ValueError | None], count: int) -> str:
    """Return the number of unusable pictures, and the reason, as a sentence; maybe empty."""
    named = "; ".join(map(str, unread[:_MOST_NAMED])) + "; ..." * (len(unread) > _MOST_NAMED)
    return f"{len(unread)} of {count} pictures are left out: {named}" if unread else ""


class _Folder:
    """Frame reader for the images of a folder."""

    dt: float | None = None
    times: Floats | None = None
    headings: int | None = None
    shortage = ""

    def __init__(self, folder: Path) -> None:
        self.files = images_in(folder)
        self.count = len(self.files)

    def name(self, index: int) -> str:
        return one_line(self.files[index])

    def read(self) -> Iterator[Pixels | ValueError]:
        for index in range(self.count):
            try:
                yield self.at(index)
            except ValueError as error:
                yield error

    def at(self, index: int) -> Pixels:
        return load_image(self.files[index])


def images_in(folder: Path) -> list[Path]:
    """Return the images of a folder in natural order; ValueError: there are no images."""
    suffixes = image_suffixes()
    files = [
        file
        for file in folder.iterdir()
        if file.suffix.lower() in suffixes and file.is_file() and not file.name.startswith(".")
    ]
    if not files:
        video = folder / "frames.mkv"
        hint = f": its video is {one_line(video)}" if video.is_file() else ""
        raise ValueError(f"there are no images in the folder {one_line(folder)}{hint}")
    return sorted(files, key=_natural_order)


def _natural_order(file: Path) -> tuple[list[str | int], str]:
    parts = re.split(r"(\d+)", file.name.lower())
    return [int(part) if part.isdecimal() else part for part in parts], file.name


def _area_seen(plane_map: PlaneMap, size: tuple[int, int]) -> tuple[int, int]:
    """Return the width and height of the work area in the frames (px)."""
    border = _border(size, 1 if plane_map.intrinsics is None else _BORDER)
    ideal = border if plane_map.intrinsics is None else plane_map.intrinsics.ideal(border)
    is_seen = np.isfinite(ideal).all()
    # The third homogeneous coordinate changes its sign at the horizon.
    scale = plane_map.matrix[2, :2] @ ideal.T + plane_map.matrix[2, 2]
    extent = plane_map.to_world(border).max(axis=0) + 0.5
    if not is_seen or np.ptp(np.sign(scale)) or extent.min() < 1:
        raise ValueError(
            "area: with this plane map, the frames do not determine the size of the area; "
            "give the area's width and height in px"
        )
    width, height = np.rint(extent).astype(int).tolist()
    return width, height


def _border(size: tuple[int, int], n: int) -> Floats:
    """Return n points of each side of a frame, from its corners on (pixels)."""
    right, bottom = size[0] - 0.5, size[1] - 0.5
    corners = np.array([(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)])
    way = np.roll(corners, -1, axis=0) - corners
    parts = np.arange(n) / n
    points: Floats = (corners[:, None] + parts[:, None] * way[:, None]).reshape(-1, 2)
    return points
