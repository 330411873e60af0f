"""Live cameras: the newest frame of a camera, a stream, or a file at its own rate."""

from robsim.lab.cameras.camera import Camera, CameraCounts
from robsim.lab.cameras.errors import (
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
from robsim.lab.cameras.features import CameraFeatures
from robsim.lab.cameras.finding import CameraReport, find_cameras

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
