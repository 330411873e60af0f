"""Live cameras: the newest frame of a camera, a stream or a file played at its own rate."""

from robsim._base.public import present as _present
from robsim.capture._camera import Camera, CameraCounts
from robsim.capture._errors import (
    CameraBusyError,
    CaptureError,
    EndOfStream,
    FrameTimeoutError,
    NoBackEndError,
    NoBandwidthError,
    NoBusError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.capture._features import CameraFeatures
from robsim.capture._finding import CameraReport, find_cameras

__all__ = [
    "Camera",
    "CameraBusyError",
    "CameraCounts",
    "CameraFeatures",
    "CameraReport",
    "CaptureError",
    "EndOfStream",
    "FrameTimeoutError",
    "NoBackEndError",
    "NoBandwidthError",
    "NoBusError",
    "NoCameraError",
    "NoPermissionError",
    "UnpluggedError",
    "find_cameras",
]

_present(globals())
