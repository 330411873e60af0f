"""State estimators to compare one's own with: each is a ready `estimate_state`.

Nothing of robsim needs this package: a course in which the students write these filters
themselves can delete its folder.
"""

from robsim.reference.constant_velocity import ConstantVelocityKalmanFilter
from robsim.reference.estimator import Prior
from robsim.reference.extended import ExtendedKalmanFilter
from robsim.reference.motion import RobotMotion
from robsim.reference.particle import ParticleFilter
from robsim.reference.unscented import UnscentedKalmanFilter

__all__ = [
    "ConstantVelocityKalmanFilter",
    "ExtendedKalmanFilter",
    "ParticleFilter",
    "Prior",
    "RobotMotion",
    "UnscentedKalmanFilter",
]
