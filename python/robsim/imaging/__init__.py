"""Images and frames: files, videos, recordings, clips."""

from robsim.imaging._clip import Clip
from robsim.imaging._images import read_picture, write_picture
from robsim.imaging._plane_maps import plane_map_from_points
from robsim.imaging._recordings import Recording
from robsim.imaging._video import VideoWriter, write_video

__all__ = [
    "Clip",
    "Recording",
    "VideoWriter",
    "plane_map_from_points",
    "read_picture",
    "write_picture",
    "write_video",
]
