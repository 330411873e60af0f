"""Controllers for ``Simulation(control=...)``, and the score of a driven path.

They follow a path, or excite the robot so that its parameters can be identified.
"""

from robsim._base.public import present as _present
from robsim._core import Controller, DriveAround, Replay, Spin
from robsim.control._excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.control._path_following import FollowPath, GoToPoint
from robsim.control._path_score import PathScore, score_path

__all__ = [
    "Chirp",
    "Controller",
    "DriveAround",
    "FollowPath",
    "GoToPoint",
    "MultiSine",
    "PathScore",
    "PseudoRandomBinary",
    "Replay",
    "Spin",
    "score_path",
]

_present(globals())
