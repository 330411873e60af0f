"""Images and frames: image files, camera noise, plane maps, lenses, calibrations, recordings."""

from robsim._base.public import present as _present
from robsim._core import Frame, Intrinsics, PlaneMap
from robsim.imaging._calibration import Calibration, Residuals
from robsim.imaging._calibration_file import load_calibration, save_calibration
from robsim.imaging._clip import Clip
from robsim.imaging._images import load_image, save_image
from robsim.imaging._noise import GaussianNoise, UniformNoise
from robsim.imaging._recordings import Recording
from robsim.imaging._video import VideoWriter, save_video

__all__ = [
    "Calibration",
    "Clip",
    "Frame",
    "GaussianNoise",
    "Intrinsics",
    "PlaneMap",
    "Recording",
    "Residuals",
    "UniformNoise",
    "VideoWriter",
    "load_calibration",
    "load_image",
    "save_calibration",
    "save_image",
    "save_video",
]

_present(globals())
