"""Images and frames: image files, camera noise, plane maps, lenses, calibrations, recordings."""

from robsim._core import Frame, Intrinsics, PlaneMap
from robsim.vision.imaging.calibration import Calibration, Residuals
from robsim.vision.imaging.calibration_file import load_calibration, save_calibration
from robsim.vision.imaging.clip import Clip
from robsim.vision.imaging.images import load_image, save_image
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise
from robsim.vision.imaging.recordings import Recording
from robsim.vision.imaging.video import VideoWriter, save_video

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
