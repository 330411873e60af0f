"""Reference state estimators to compare one's own with: each is a ready `estimate_state`.

No other part of robsim needs this package: a course in which the students write these filters
themselves can delete its folder.

A filter is consistent if the noises it is given are those of the world. In a simulation with
``process_noise=noise``, a `PoseNoise`, a filter gets ``process_sigma=noise.sigma``; in one with
``motor_delay=d`` it gets the same delay.
"""

from robsim.estimation.reference.estimator import Prior, RobotMotion
from robsim.estimation.reference.kalman import (
    ConstantVelocityKalmanFilter,
    ExtendedKalmanFilter,
    UnscentedKalmanFilter,
)
from robsim.estimation.reference.particle import ParticleFilter

__all__ = [
    "ConstantVelocityKalmanFilter",
    "ExtendedKalmanFilter",
    "ParticleFilter",
    "Prior",
    "RobotMotion",
    "UnscentedKalmanFilter",
]
