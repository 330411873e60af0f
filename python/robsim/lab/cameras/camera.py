"""The class `Camera`: the newest frame of a source that runs by itself."""

from __future__ import annotations

import atexit
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from typing import Any

from robsim import _core
from robsim._core import Frame, PlaneMap
from robsim.base.checks import (
    check_bool,
    check_float,
    check_int,
    check_kind,
    check_size,
    check_text,
)
from robsim.base.in_browser import check_has_threads
from robsim.base.text import one_line
from robsim.base.values import Closing
from robsim.lab.cameras.errors import CaptureError, EndOfStream, FrameTimeoutError
from robsim.lab.cameras.features import CameraFeatures
from robsim.lab.cameras.sources import Source, source_of
from robsim.lab.cameras.wishes import Wishes
from robsim.vision.imaging.calibration import Calibration, check_region
from robsim.vision.imaging.calibration_file import as_calibration

_LONGEST = 3600.0  # s, of a time-out
_LAST_PATIENCE = 6.0  # s at the end of the interpreter, longer than a stalled stream is read


@dataclass(frozen=True)
class CameraCounts:
    """What has become of the frames of a camera.

    Attributes
    ----------
    grabbed : int
        Complete frames that came.
    delivered : int
        Those that a reader took.
    dropped : int
        Frames that a newer one replaced before a reader took them, and old ones of a stream.
    torn : int
        Torn or short ones, which no reader gets.
    timeouts : int
        Waits of `frame_timeout` in which none came.
    reopened : int
        Times that the camera was opened again.
    """

    grabbed: int = 0
    delivered: int = 0
    dropped: int = 0
    torn: int = 0
    timeouts: int = 0
    reopened: int = 0


class Camera(Closing):
    """A live camera, as an iterable of frames: the newest one each time, and none twice.

    A native thread reads the camera all the time and keeps its newest frame, so that a slow reader
    sees what is there now, and not what was seconds ago. What nobody reads in time is dropped, and
    counted. A file is played at its own rate in the same way: `Recording` gives all of its
    frames, each when it is asked for.

    Parameters
    ----------
    source : int, str or path
        Number of a camera (of ``/dev/video0``: 0); an address such as
        ``"http://camera.local/video.mjpg"``, ``"rtsp://camera.local/stream"``,
        ``"gige://192.168.1.20"`` (or a serial number or name: a GigE Vision camera), or
        ``"firewire://"`` (the first camera on FireWire; ``"firewire://1"`` is the second one, and
        16 digits stand for a certain one); a video file or a folder of images; or an object of
        robsim that is a camera.
    back_end : str, optional
        The reader. Of an address: ``"http"``, which reads MJPEG, tells torn images from whole ones,
        and logs in by ``http://user:password@host`` where the camera requires it; or ``"ffmpeg"``
        or ``"gstreamer"`` of OpenCV. Of a number: ``"v4l2"``, ``"msmf"``, ``"dshow"``,
        ``"avfoundation"`` or ``"gstreamer"``. Default: HTTP for ``http://``, FFmpeg for other
        addresses, and for a number the one of the operating system.
    plane_map : PlaneMap, optional
        Map from frame pixels to the work area. Default: the frames show exactly the whole area,
        seen vertically from above.
    area : tuple of int, optional
        Width and height of the work area (px). Default: that of the calibration, or the size of the
        frames.
    size : tuple of int, optional
        Width and height of the frames (px), asked of a camera by number, on FireWire or on GigE.
        Frames of another size are an error. Default: that of the calibration, or the camera's own.
    region : tuple of int, optional
        Left, top, width and height of the part of the sensor that is sent (px): on FireWire, by
        its format 7, and on GigE. Default: all of it; on GigE as the camera has it.
    fps : float, optional
        Frames per second: asked of a camera by number, on FireWire or on GigE; that of another
        address, which tells none; the rate at which a folder is played. Default: that of the file;
        on FireWire 30, or the next lower one that the camera, and the bus, can have; on GigE that
        which the camera has; otherwise `dt` is unknown. On FireWire and GigE a warning names
        another rate than the required one, and `dt` has it. A run warns of any camera that sends a
        half, a third or less of it.
    coding : str, optional
        How a camera codes its pixels: on FireWire one of ``"yuv422"``, ``"rgb8"``, ``"yuv444"``,
        ``"raw8"``, ``"yuv411"``, ``"mono8"``, ``"mono16"``; on GigE one of ``"rgb8"``, ``"raw8"``,
        ``"yuv422"``, ``"mono8"``. Default: the first of these that it has at that rate. ``raw8``
        comes from behind a Bayer filter.
    features : CameraFeatures, optional
        Exposure, gain, white balance and the like, on FireWire and on GigE. Default: all as they
        are, and none automatic.
    every : int
        Only each n-th frame is handed over.
    open_timeout : float
        Maximum wait for the first frame (s).
    frame_timeout : float
        Maximum wait for each other frame (s).
    reopen : bool
        Whether a camera that is unplugged, or from which nothing has come for three
        `frame_timeout`, is opened again, with pauses of 0.5 s to 5 s; meanwhile reading it ends
        in FrameTimeoutError.
    calibration : Calibration or path, optional
        That of the camera, in place of `plane_map`: see `robsim.vision.load_calibration`. Frames
        of another size are refused.

    Attributes
    ----------
    source : object
        As given.
    size : tuple of int
        Width and height of the frames (px).
    area : tuple of int
        Width and height of the work area (px).
    plane_map : PlaneMap
        Map from frame pixels to the work area.
    dt : float or None
        Time between two frames that are handed over (s); None = unknown.
    region : tuple of int or None
        Left, top, width and height of the part of the sensor that is sent (px), if that can be
        chosen.
    coding : str or None
        How the camera codes pixels, if that can be chosen.
    calibration : Calibration or None
        That of the camera.

    Raises
    ------
    CaptureError
        If it cannot be opened or read, of the kind that says why: NoBackEndError,
        NoBusError, NoPermissionError, NoCameraError, NoBandwidthError, CameraBusyError,
        FrameTimeoutError, UnpluggedError.
    FileNotFoundError
        If there is no such file or folder.
    TypeError, ValueError
        If an argument has the wrong type or is out of range, a file is no video, or no rate is
        given for a folder.

    Notes
    -----
    The times of the frames (s) start at the first one: ``t`` is that of the exposure, as far as the
    camera lets it be known, ``t_arrival`` that of the arrival. A camera belongs to the process that
    opened it. A separate process reads network cameras and cameras by number, and ends with the
    camera: so a callback that keeps the interpreter sees fresh frames all the same. On Windows it
    is this process.

    Frames of RTSP carry stamps. A frame that waited 0.1 s longer on its way than the freshest of
    the last 10 s is old: it is dropped, and counted. The camera's encoder may delay all frames by
    the same time, which no stamp tells.

    Examples
    --------
    A real camera has a number, ``robsim.Camera(0)``, a device or an address,
    ``robsim.Camera("http://camera.local/video.mjpg")``; here the simulated laboratory has one:

    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     trace = robsim.Experiment(camera).run(3)
    >>> camera.size, len(trace)
    ((1200, 1200), 3)
    """

    def __init__(
        self,
        source: int | str | PathLike[str] | Any,
        *,
        back_end: str | None = None,
        plane_map: PlaneMap | None = None,
        area: tuple[int, int] | None = None,
        size: tuple[int, int] | None = None,
        region: tuple[int, int, int, int] | None = None,
        fps: float | None = None,
        coding: str | None = None,
        features: CameraFeatures | None = None,
        every: int = 1,
        open_timeout: float = 5.0,
        frame_timeout: float = 1.0,
        reopen: bool = False,
        calibration: Calibration | str | PathLike[str] | None = None,
    ) -> None:
        check_has_threads("A camera")
        check_kind("plane_map", plane_map, PlaneMap, or_none=True)
        every = check_int("every", every, minimum=1, maximum=10_000)
        self._frame_timeout = _seconds("frame_timeout", frame_timeout)
        open_timeout = _seconds("open_timeout", open_timeout)
        reopen = check_bool("reopen", reopen)
        area = None if area is None else check_size("area", area)
        check_kind("features", features, CameraFeatures, or_none=True)
        if fps is not None:
            fps = check_float("fps", fps, "1/s", exclusive_minimum=0, maximum=1000)
        size = None if size is None else check_size("size", size)
        self.calibration = as_calibration(calibration, plane_map)
        if self.calibration is not None:
            plane_map, area = self.calibration.plane_map, area or self.calibration.area
        wishes = Wishes(
            back_end=back_end,
            size=self.calibration.size if size is None and self.calibration else size,
            region=None if region is None else check_region("region", region),
            fps=fps,
            coding=None if coding is None else check_text("coding", coding),
            features=features,
        )
        try:
            opened = source_of(source, wishes, open_timeout=open_timeout)
        except CaptureError as error:
            # Those of other kinds say why there is no camera.
            if type(error) is CaptureError and size is None and self.calibration is not None:
                width, height = self.calibration.size
                error.add_note(f"asked for were {width} x {height} px, those of calibration")
            raise
        self._device = opened.device
        self.region, self.coding = opened.region, opened.coding
        self._headings = opened.headings
        self.source = source
        area = area or opened.area
        plane_map = opened.plane_map if plane_map is None else plane_map
        self._grabber = _core.Grabber(
            opened.device,
            every=every,
            frame_timeout=self._frame_timeout,
            reopen=reopen,
            interval=opened.dt,
            plane_map=plane_map,
            area=area,
            size=size,
            headings=opened.headings,
        )
        _open_cameras.add(self)
        self.size = self._first_size(opened, open_timeout)
        self.area = self.size if area is None else area
        self.plane_map = plane_map or PlaneMap.scaled(resolution=self.size, area=self.area)
        self.dt = None if opened.dt is None else opened.dt * every

    def _first_size(self, opened: Source, timeout: float) -> tuple[int, int]:
        try:
            size = self._grabber.wait_for_size(timeout)
            if size is None:
                torn = self.counts.torn
                raise FrameTimeoutError(
                    f"{opened.name} gave no {'whole ' * bool(torn)}frame within open_timeout = "
                    f"{timeout:g} s"
                    + (
                        f", and {torn} torn ones: {opened.advice or 'does the line lose data?'}"
                        if torn
                        else ": does it send, and does the address say where?"
                    )
                )
            if self.calibration is not None:
                self.calibration.check_frames(size, opened.region)
        except BaseException:
            self.close()
            raise
        return size

    def read(self, timeout: float | None = None) -> Frame:
        """Return the newest frame that nobody has read yet; wait for one if there is none.

        Other Python threads run while it waits.

        Parameters
        ----------
        timeout : float, optional
            Maximum wait (s). Default: `frame_timeout`.

        Raises
        ------
        FrameTimeoutError
            If none comes in time. It can be tried again.
        EndOfStream
            If the file is over.
        CaptureError
            If the camera cannot be read any more.
        ValueError
            If it is closed.
        """
        limit = self._frame_timeout if timeout is None else _seconds("timeout", timeout)
        frame = self._grabber(limit)
        if frame is None:
            raise FrameTimeoutError(
                f"no frame came from {one_line(self.source)} within {limit:g} s: it can be tried "
                "again"
            )
        return frame

    def __iter__(self) -> Iterator[Frame]:
        while True:
            try:
                yield self.read()
            except EndOfStream:
                return

    @property
    def newest(self) -> Frame | None:
        """Frame or None: the last one that a reader took; any thread may look at it."""
        return self._grabber.newest

    @property
    def features(self) -> CameraFeatures | None:
        """CameraFeatures or None: how it is set now, as `Camera` takes it; None if it has no such.

        Set it to change what is not None in it, also while frames come.
        """
        states = getattr(self._device, "features", None)
        return None if states is None else CameraFeatures._of(states)

    @features.setter
    def features(self, features: CameraFeatures) -> None:
        check_kind("features", features, CameraFeatures)
        if not hasattr(self._device, "set_features"):
            raise ValueError(f"{one_line(self.source)} is no camera whose features can be set")
        self._device.set_features(features._wishes())

    @property
    def counts(self) -> CameraCounts:
        """CameraCounts: what has become of the frames so far."""
        return CameraCounts(*self._grabber.counts)

    def close(self) -> None:
        """Give the camera back; a reader that waits gets a ValueError."""
        self._grabber.close()

    def __repr__(self) -> str:
        return f"<Camera {one_line(self.source)}: {self.size[0]} x {self.size[1]} px>"


def _seconds(name: str, value: Any) -> float:
    return check_float(name, value, "s", minimum=0, maximum=_LONGEST)


_open_cameras: weakref.WeakSet[Camera] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    # A thread that still called Python after its end would crash.
    for camera in list(_open_cameras):
        camera._grabber.close(_LAST_PATIENCE)
