"""Images and frames: files, videos, recordings, clips."""

from robsim.imaging._clip import Clip
from robsim.imaging._images import load_image, save_image
from robsim.imaging._plane_maps import plane_map_from_points
from robsim.imaging._recordings import Recording
from robsim.imaging._video import VideoWriter, save_video

__all__ = [
    "Clip",
    "Recording",
    "VideoWriter",
    "load_image",
    "plane_map_from_points",
    "save_image",
    "save_video",
]
