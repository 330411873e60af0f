"""The class `Camera`: the newest frame of a continuous source."""

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
    """The counts of a camera's frames.

    Attributes
    ----------
    grabbed : int
        Complete frames received.
    delivered : int
        Frames taken by a reader.
    dropped : int
        Frames replaced by a newer one before a reader took them, and old frames of a stream.
    torn : int
        Torn or short frames, which no reader receives.
    timeouts : int
        Waits of `frame_timeout` without a frame.
    reopened : int
        Number of times that the camera was opened again.
    """

    grabbed: int = 0
    delivered: int = 0
    dropped: int = 0
    torn: int = 0
    timeouts: int = 0
    reopened: int = 0


class Camera(Closing):
    """A live camera as an iterable of its newest frames; no frame is returned twice.

    A native thread reads the camera all the time and keeps its newest frame, so that even a slow
    reader gets a current frame. Frames that no reader takes in time are dropped and counted. A file
    also plays at its own rate, like a camera; use `Recording` to read every frame on demand.

    Parameters
    ----------
    source : int, str or path
        Number of a camera (0 for ``/dev/video0``), an address, a video file, a folder of images,
        or an object: a `SimulatedLab`, or one with ``open``, ``read`` and ``close``. Addresses are
        ``"http://camera.local/video.mjpg"``, ``"rtsp://camera.local/stream"``, and
        ``"gige://192.168.1.20"`` (or a serial number or name) for GigE Vision. ``"firewire://"`` is
        the first camera on FireWire, ``"firewire://1"`` the second one, and 16 digits name a
        specific camera.
    back_end : str, optional
        The reader. The readers of an address are ``"http"``, and OpenCV's ``"ffmpeg"`` and
        ``"gstreamer"``. ``"http"`` reads MJPEG, detects torn images, and logs in by
        ``http://user:password@host`` if the camera requires it. The readers of a camera number are
        ``"v4l2"``, ``"msmf"``, ``"dshow"``, ``"avfoundation"`` and ``"gstreamer"``. Default: HTTP
        for ``http://``, FFmpeg for other addresses, and the operating system's back end for a
        camera number.
    plane_map : PlaneMap, optional
        Map from frame pixels to the work area. By default, the frames show exactly the whole area,
        seen vertically from above.
    area : tuple of int, optional
        Width and height of the work area (px). Default: the area of the calibration if there is
        one, otherwise the size of the frames.
    size : tuple of int, optional
        Width and height of the frames (px), requested from a camera by number, on FireWire or on
        GigE. Frames of another size cause an error. Default: the calibration's or camera's size.
    region : tuple of int, optional
        Left, top, width and height of the transmitted part of the sensor (px): on FireWire, by
        its format 7, and on GigE. Default: the whole sensor, or on GigE the camera's current
        setting.
    fps : float, optional
        Frames per second: requested from a camera by number, on FireWire or on GigE; the rate of
        an address without its own rate; or the playback rate of a folder. Default: the rate of the
        file, or the current rate of the GigE camera. On FireWire, the default is 30 frames per
        second, or the next lower rate that camera and bus support. For other sources, `dt` is
        unknown by default. On FireWire and GigE a warning reports a rate that differs from the
        requested rate, and `dt` follows the actual rate. A run warns if any camera sends at most
        half of its rate.
    coding : str, optional
        The camera's pixel coding: on FireWire one of ``"yuv422"``, ``"rgb8"``, ``"yuv444"``,
        ``"raw8"``, ``"yuv411"``, ``"mono8"``, ``"mono16"``; on GigE one of ``"rgb8"``, ``"raw8"``,
        ``"yuv422"``, ``"mono8"``. Default: the first of these codings that the camera supports at
        its frame rate. ``raw8`` comes from behind a Bayer filter.
    features : CameraFeatures, optional
        Exposure, gain, white balance and similar, on FireWire and on GigE. Default: the camera's
        current values, without automatic control.
    every : int
        Deliver only every n-th frame.
    open_timeout : float
        Maximum wait for the first frame (s).
    frame_timeout : float
        Maximum wait for each other frame (s).
    reopen : bool
        Whether to open a camera again that is unplugged, or sends nothing for three
        `frame_timeout`, with pauses of 0.5 s to 5 s. Reading then ends in FrameTimeoutError.
    calibration : Calibration or path, optional
        The camera's calibration, instead of `plane_map`: see `robsim.vision.load_calibration`.
        Frames of another size are refused.

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
        Time between two delivered frames (s); None = unknown.
    region : tuple of int or None
        Left, top, width and height of the transmitted part of the sensor (px), if selectable.
    coding : str or None
        The camera's pixel coding, if selectable.
    calibration : Calibration or None
        The camera's calibration.

    Raises
    ------
    CaptureError
        If the camera cannot be opened or read. The subclass gives the reason: NoBackEndError,
        NoBusError, NoPermissionError, NoCameraError, NoBandwidthError, CameraBusyError,
        FrameTimeoutError, UnpluggedError.
    FileNotFoundError
        If the file or folder does not exist.
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or a file is not a video. If `fps` is
        missing for a folder.

    Notes
    -----
    The times of the frames (s) start at the first frame: ``t`` is the exposure time, if known, and
    ``t_arrival`` is the arrival time. A camera belongs to the process that opened it. A separate
    process reads network cameras and cameras by number, so frames stay current even while a
    callback blocks the interpreter. That process ends when the camera is closed. On Windows, the
    calling process reads these cameras.

    RTSP frames carry stamps. A frame is dropped and counted if its delay exceeds the smallest delay
    of the last 10 s by 0.1 s. The camera's encoder may delay all frames by the same time, which the
    stamps do not show.

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
            # Other kinds of errors explain the missing camera.
            if type(error) is CaptureError and size is None and self.calibration is not None:
                width, height = self.calibration.size
                error.add_note(f"the requested size was {width} x {height} px, from calibration")
            raise
        self._device = opened.device
        self.region, self.coding = opened.region, opened.coding
        self._headings = opened.headings
        self._knows_exposure = opened.knows_exposure
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
        """Return the newest unread frame; wait for one if necessary.

        Other Python threads run meanwhile.

        Parameters
        ----------
        timeout : float, optional
            Maximum wait (s). Default: `frame_timeout`.

        Raises
        ------
        FrameTimeoutError
            If no frame comes in time. Reading can be tried again.
        EndOfStream
            If the file has ended.
        CaptureError
            If reading the camera fails.
        ValueError
            If the camera is closed.
        """
        limit = self._frame_timeout if timeout is None else _seconds("timeout", timeout)
        frame = self._grabber(limit)
        if frame is None:
            raise FrameTimeoutError(
                f"no frame came from {one_line(self.source)} within {limit:g} s: try again"
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
        """Frame or None: the last frame that a reader took; any thread may read this attribute."""
        return self._grabber.newest

    @property
    def features(self) -> CameraFeatures | None:
        """CameraFeatures or None: the current settings; None if the camera has no features.

        Assign new settings to change the features; a value of None keeps the current setting. This
        also works during reading.
        """
        states = getattr(self._device, "features", None)
        return None if states is None else CameraFeatures._of(states)

    @features.setter
    def features(self, features: CameraFeatures) -> None:
        check_kind("features", features, CameraFeatures)
        if not hasattr(self._device, "set_features"):
            raise ValueError(f"{one_line(self.source)} does not allow a change of its features")
        self._device.set_features(features._wishes())

    @property
    def counts(self) -> CameraCounts:
        """CameraCounts: the counts of frames so far."""
        return CameraCounts(*self._grabber.counts)

    def close(self) -> None:
        """Release the camera; a waiting reader gets a ValueError."""
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
