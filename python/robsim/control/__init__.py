"""Controllers: paths to follow, excitation for identification, and a score of the path."""

from robsim.control._excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.control._path_following import FollowPath, GoToPoint
from robsim.control._path_score import PathScore, score_path

__all__ = [
    "Chirp",
    "FollowPath",
    "GoToPoint",
    "MultiSine",
    "PathScore",
    "PseudoRandomBinary",
    "score_path",
]
