"""Recorded frames from a video file or a folder of images, for `Experiment`."""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Iterator
from contextlib import closing
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap
from robsim.base.checks import Floats, check_float, check_int, check_kind, check_size
from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.base.warn import warn_user
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import as_calibration
from robsim.vision.imaging.images import (
    MOST_PIXELS,
    Pixels,
    check_same_size,
    frame_size,
    image_suffixes,
    load_image,
)
from robsim.vision.imaging.video import check_is_video, load_opencv, noted_headings, quiet

_COMPLETE = 0.95  # fraction of the frames; some files only estimate their number
MAXIMUM_RATE = 1000.0  # 1/s; files with an unknown frame rate often claim this or more

_LONGEST_DT = 1e6  # s
_MOST_HEADINGS = 2**31 - 1
_BORDER = 32  # points of each side of a frame that a lens bends


class Recording:
    """A video file or a folder of images, as an iterable of frames; each iteration restarts.

    In lock step: each frame comes when it is asked for, however late, and none is lost.
    ``robsim.Camera(file)`` plays it at its own rate, and drops what nobody takes in time.

    Parameters
    ----------
    source : path
        A video file, or a folder of images in any format that Pillow reads, taken in natural order
        of their names (frame2 before frame10). Other files in the folder are ignored.
    plane_map : PlaneMap, optional
        Map from frame pixels to the work area. Default: the frames show exactly the whole area,
        seen vertically from above.
    area : tuple of int, optional
        Width and height of the work area (px). Default: that of the calibration, or the extent that
        the frames show; without a plane map, the size of the frames.
    dt : float, optional
        Time between two frames (s). Default: that of the video file; images in a folder have none.
    calibration : Calibration or path, optional
        That of the camera, in place of `plane_map`. Frames of another size are refused.
    headings : int, optional
        Number of headings that the robot is drawn in, at whole pixels, as a simulation does it;
        then covariances of measured poses count that in. Default: what a video of robsim tells,
        otherwise any, as a camera sees it. Images in a folder do not tell.

    Attributes
    ----------
    source : pathlib.Path
        The file or folder.
    plane_map : PlaneMap
        Map from frame pixels to the work area.
    area : tuple of int
        Width and height of the work area (px).
    dt : float or None
        Time between two frames (s): frame k has the time k dt. None = unknown: the frames have no
        times, and an `Experiment` takes the dt of its model.
    size : tuple of int
        Width and height of the frames (px).
    count : int or None
        Number of frames, as the file claims; None = unknown.
    calibration : Calibration or None
        That of the camera.
    headings : int or None
        Number of headings that the robot is drawn in; None = any, or not known.

    Raises
    ------
    FileNotFoundError
        If there is no such file or folder.
    ImportError
        If it is a video, and OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type, the file is not a video, has no frames or no plausible
        frame rate, if the folder has no images, if `dt` or `area` is not positive. During
        iteration: if a frame is damaged, or its size differs from that of the first.

    Warns
    -----
    UserWarning
        If a video ends early because it is truncated or damaged.

    Examples
    --------
    >>> for frame in robsim.Recording("run.mkv", area=(1200, 1200)):
    ...     blobs = robsim.find_blobs(frame, robsim.load_colors())
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
                f"source must be a video file or a folder of images, got {quoted(source)}: for a "
                "live camera, give its frames to robsim.Experiment"
            )
        self.source = as_path(source, "source")
        check_kind("plane_map", plane_map, PlaneMap, or_none=True)
        if not self.source.exists():
            raise FileNotFoundError(f"there is no file or folder {one_line(self.source)}")
        self.calibration = as_calibration(calibration, plane_map)
        self._images = _Folder(self.source) if self.source.is_dir() else _Video(self.source)
        self.size = self._first_size()
        if self.calibration is not None:
            self.calibration.check_frames(self.size)
            plane_map, area = self.calibration.plane_map, area or self.calibration.area
        self.dt = (
            self._images.dt()
            if dt is None
            else check_float("dt", dt, "s", exclusive_minimum=0, maximum=1e6)
        )
        self.count = self._images.count()
        self.headings = (
            self._images.headings()
            if headings is None
            else check_int("headings", headings, minimum=1, maximum=_MOST_HEADINGS)
        )
        if area is not None:
            self.area = check_size("area", area)
        else:
            self.area = self.size if plane_map is None else _area_seen(plane_map, self.size)
        self.plane_map = plane_map or PlaneMap.scaled(resolution=self.size, area=self.area)

    def __iter__(self) -> Iterator[Frame]:
        with closing(self._images.read()) as images:
            for index, (name, pixels) in enumerate(images):
                yield self._frame(index, name, pixels)

    def _frame(self, index: int, name: str, pixels: Pixels) -> Frame:
        check_same_size(name, frame_size(pixels), self.size)
        t = None if self.dt is None else index * self.dt
        return Frame(pixels, t=t, index=index, plane_map=self.plane_map, headings=self.headings)

    def _at(self, index: int) -> Frame:
        """Return a frame, in any order; IndexError if there is none."""
        return self._frame(index, *self._images.at(index))

    def __repr__(self) -> str:
        count = "frames" if self.count is None else f"{self.count} frames"
        width, height = self.size
        dt = "no times" if self.dt is None else f"dt = {self.dt:g} s"
        return f"<Recording {one_line(self.source)}: {count} of {width} x {height} px, {dt}>"

    def _first_size(self) -> tuple[int, int]:
        with closing(self._images.read()) as images:
            for _, pixels in images:
                return frame_size(pixels)
        raise ValueError(f"{one_line(self.source)} has no frames")


class _Folder:
    """Frame reader for the images of a folder."""

    def __init__(self, folder: Path) -> None:
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
        self.files = sorted(files, key=_natural_order)

    def dt(self) -> float | None:
        return None

    def count(self) -> int:
        return len(self.files)

    def headings(self) -> int | None:
        return None

    def read(self) -> Generator[tuple[str, Pixels]]:
        for file in self.files:
            yield one_line(file), load_image(file)

    def at(self, index: int) -> tuple[str, Pixels]:
        file = self.files[index]
        return one_line(file), load_image(file)


def _natural_order(file: Path) -> tuple[list[str | int], str]:
    parts = re.split(r"(\d+)", file.name.lower())
    return [int(part) if part.isdecimal() else part for part in parts], file.name


class _Video:
    """Frame reader for a video file, by OpenCV."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.cv2 = load_opencv("reading a video")
        check_is_video(file)
        with quiet(self.cv2):
            capture = self._open()
            self.rate = float(capture.get(self.cv2.CAP_PROP_FPS))
            self.frames = capture.get(self.cv2.CAP_PROP_FRAME_COUNT)
            size = [capture.get(self.cv2.CAP_PROP_FRAME_WIDTH)]
            size.append(capture.get(self.cv2.CAP_PROP_FRAME_HEIGHT))
            capture.release()
        if not size[0] * size[1] <= MOST_PIXELS:  # True for NaN, too
            raise ValueError(
                f"{one_line(file)} must have frames of at most {MOST_PIXELS} px, got "
                f"{size[0]:g} x {size[1]:g} px"
            )

    def dt(self) -> float:
        if not 0 < self.rate < MAXIMUM_RATE:  # False for NaN, too
            raise ValueError(
                f"{one_line(self.file)} has the frame rate {self.rate:g} per second, which is "
                "implausible: give dt, the time between two frames in s"
            )
        return 1 / self.rate

    def count(self) -> int | None:
        known = math.isfinite(self.frames) and self.frames > 0
        return int(self.frames) if known else None

    def headings(self) -> int | None:
        return noted_headings(self.file)

    def read(self) -> Generator[tuple[str, Pixels]]:
        with quiet(self.cv2):
            capture = self._open()
        index = 0
        # Nothing has to be done at the end, which may be that of Python: the file closes by itself.
        while (pixels := self._next(capture)) is not None:
            yield f"frame {index} of {one_line(self.file)}", pixels
            index += 1
        known = self.count()
        if known is not None and index < _COMPLETE * known:
            warn_user(
                f"{one_line(self.file)} ends after {index} of {known} frames: it is truncated or "
                "damaged"
            )

    def at(self, index: int) -> tuple[str, Pixels]:
        with quiet(self.cv2):
            capture = self._open()
            capture.set(self.cv2.CAP_PROP_POS_FRAMES, index)
            is_there = round(capture.get(self.cv2.CAP_PROP_POS_FRAMES)) == index
        name = f"frame {index} of {one_line(self.file)}"
        if is_there and (pixels := self._next(capture)) is not None:
            return name, pixels
        # A file without an index: from its beginning.
        found = next(islice(self.read(), index, None), None)
        if found is None:
            raise IndexError(f"there is no {name}")
        return found

    def _open(self) -> Any:
        # More threads are no faster, and print their warnings at any time.
        one_thread = [self.cv2.CAP_PROP_N_THREADS, 1]
        # The whole path: "concat:a.mp4" would be more than the name of a file.
        capture = self.cv2.VideoCapture(str(self.file.absolute()), self.cv2.CAP_FFMPEG, one_thread)
        if not capture.isOpened():
            raise ValueError(f"{one_line(self.file)} is not a video, or it is damaged or truncated")
        return capture

    def _next(self, capture: Any) -> Pixels | None:
        with quiet(self.cv2):
            is_read, pixels = capture.read()
        if not is_read:
            return None
        rgb: Pixels = self.cv2.cvtColor(pixels, self.cv2.COLOR_BGR2RGB)
        return rgb


def _area_seen(plane_map: PlaneMap, size: tuple[int, int]) -> tuple[int, int]:
    """Return the width and height of the work area that the frames show (px)."""
    border = _border(size, 1 if plane_map.intrinsics is None else _BORDER)
    ideal = border if plane_map.intrinsics is None else plane_map.intrinsics.ideal(border)
    is_seen = np.isfinite(ideal).all()
    # The third homogeneous coordinate changes its sign at the horizon.
    scale = plane_map.matrix[2, :2] @ ideal.T + plane_map.matrix[2, 2]
    extent = plane_map.to_world(border).max(axis=0) + 0.5
    if not is_seen or np.ptp(np.sign(scale)) or extent.min() < 1:
        raise ValueError(
            "area: with this plane map the frames do not show how large the area is, "
            "give its width and height in px"
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
