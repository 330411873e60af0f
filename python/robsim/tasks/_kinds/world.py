"""What the worlds of the tasks have in common: small frames, noise, dropouts."""

from __future__ import annotations

from robsim._core import RobotModel
from robsim.imaging import GaussianNoise
from robsim.simulation import Dropout

#: Work area and frame (px): a ninth of the pixels, so that many runs are quick.
AREA, RESOLUTION = (1200, 1200), (400, 400)

#: Time of a step (s).
DT = RobotModel().dt

#: How long the robot is hidden at a time (steps).
_HIDDEN_STEPS = 3


def camera_noise(percent: float) -> GaussianNoise | None:
    """Return the noise of a level in percent; None for 0."""
    return GaussianNoise(percent) if percent > 0 else None


def dropout_of(probability: float) -> Dropout | None:
    """Return dropouts with a probability; None for 0."""
    return Dropout(probability, steps=_HIDDEN_STEPS) if probability > 0 else None
