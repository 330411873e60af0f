"""Reference state estimators for comparison: each is a ready `estimate_state`.

No other part of robsim needs this package: a course in which the students write these filters
themselves can delete its folder.

A filter is consistent if its noises equal the world's. In a simulation with
``process_noise=noise``, a `PoseNoise`, a filter gets ``process_sigma=noise.sigma``. In one with
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
