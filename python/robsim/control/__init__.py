"""Controllers for ``Simulation(control=...)``, and scores of a driven path and of parking.

They follow a path, or excite the robot for the identification of its parameters.
"""

from robsim._core import Controller, DriveAround, Replay, Spin
from robsim.control.excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.control.path_following import FollowPath, GoToPoint
from robsim.control.scores import PathScore, PoseScore, score_path, score_pose

__all__ = [
    "Chirp",
    "Controller",
    "DriveAround",
    "FollowPath",
    "GoToPoint",
    "MultiSine",
    "PathScore",
    "PoseScore",
    "PseudoRandomBinary",
    "Replay",
    "Spin",
    "score_path",
    "score_pose",
]
