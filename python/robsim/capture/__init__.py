"""Live cameras: the newest frame of a camera, a stream or a file played at its own rate."""

from robsim._base.public import present as _present
from robsim.capture._camera import Camera, CameraCounts
from robsim.capture._errors import (
    CameraBusyError,
    CaptureError,
    EndOfStream,
    FrameTimeoutError,
    NoBackEndError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.capture._finding import CameraReport, find_cameras

__all__ = [
    "Camera",
    "CameraBusyError",
    "CameraCounts",
    "CameraReport",
    "CaptureError",
    "EndOfStream",
    "FrameTimeoutError",
    "NoBackEndError",
    "NoCameraError",
    "NoPermissionError",
    "UnpluggedError",
    "find_cameras",
]

_present(globals())
