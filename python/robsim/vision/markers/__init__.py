"""Vision: colour classes and their files, blobs, the pose from two markers, colour scores."""

from robsim._core import (
    Blob,
    ColorClass,
    Detection,
    MarkerLayout,
    Measurement,
    MissedDetections,
    classify,
    color_histograms,
    detect,
    find_blobs,
    locate,
    rgb_to_yuv,
    surrounding_chroma,
)
from robsim.vision.markers.color_files import colors_to_toml, load_colors, save_colors
from robsim.vision.markers.color_score import ColorScore, score_color
from robsim.vision.markers.missed_detections import SmallMarkersWarning
from robsim.vision.markers.painting import paint_classes
from robsim.vision.markers.trained_color import TrainedColor
from robsim.vision.markers.training import train_color, train_markers

__all__ = [
    "Blob",
    "ColorClass",
    "ColorScore",
    "Detection",
    "MarkerLayout",
    "Measurement",
    "MissedDetections",
    "SmallMarkersWarning",
    "TrainedColor",
    "classify",
    "color_histograms",
    "colors_to_toml",
    "detect",
    "find_blobs",
    "load_colors",
    "locate",
    "paint_classes",
    "rgb_to_yuv",
    "save_colors",
    "score_color",
    "surrounding_chroma",
    "train_color",
    "train_markers",
]
