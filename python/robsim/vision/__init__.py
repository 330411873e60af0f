"""Colours: files, masks, and how robustly they are found."""

from robsim.vision._color_files import colors_to_toml, load_colors, save_colors
from robsim.vision._color_masks import paint_classes
from robsim.vision._color_score import ColorScore, score_color

__all__ = [
    "ColorScore",
    "colors_to_toml",
    "load_colors",
    "paint_classes",
    "save_colors",
    "score_color",
]
