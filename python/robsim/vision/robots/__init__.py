"""Robots: their definitions (image, outline, markers), their files, the default robot."""

from robsim.vision.robots.definition import BlobMarker, RobotDefinition
from robsim.vision.robots.files import save_robot
from robsim.vision.robots.finding import robot_from_image
from robsim.vision.robots.lookup import (
    default_robot,
    load_robot,
    reset_default_robot,
    robot_names,
    set_default_robot,
)
from robsim.vision.robots.marker_check import check_colors
from robsim.vision.robots.user_robots import add_robot, remove_robot, rotate_robot

__all__ = [
    "BlobMarker",
    "RobotDefinition",
    "add_robot",
    "check_colors",
    "default_robot",
    "load_robot",
    "remove_robot",
    "reset_default_robot",
    "robot_from_image",
    "robot_names",
    "rotate_robot",
    "save_robot",
    "set_default_robot",
]
