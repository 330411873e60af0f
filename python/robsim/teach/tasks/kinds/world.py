"""What the worlds of the tasks have in common: small frames, noise, dropouts; and their errors."""

from __future__ import annotations

from typing import Any

import numpy as np

from robsim._core import RobotModel
from robsim.base.checks import Floats
from robsim.simulation import Dropout, Scenario
from robsim.vision.imaging.noise import GaussianNoise

#: Work area and frame (px): a ninth of the pixels, so that many runs are quick.
AREA, RESOLUTION = (1200, 1200), (400, 400)

#: Time of a step (s).
DT = RobotModel().dt

#: How long the robot is hidden at a time (steps).
_HIDDEN_STEPS = 3


def small_world(
    *,
    noise: float,
    dropout: float = 0.0,
    area: tuple[int, int] = AREA,
    resolution: tuple[int, int] = RESOLUTION,
    **options: Any,
) -> Scenario:
    """Return a world in which vision measures the pose, with camera noise (%) and dropouts."""
    return Scenario(
        robot="lab",
        area=area,
        resolution=resolution,
        start="random",
        noise=GaussianNoise(noise) if noise > 0 else None,
        dropout=Dropout(dropout, steps=_HIDDEN_STEPS) if dropout > 0 else None,
        measure=True,
        **options,
    )


def rms(rows: Floats) -> float:
    """Return the rms length of rows; NaN if there are none."""
    return float(np.sqrt(np.mean((rows**2).sum(axis=1)))) if len(rows) else float("nan")


def rms_of_poses(errors: Floats) -> dict[str, float]:
    """Return the rms of errors of poses, (N, 3): of the position (px), of the heading (degrees)."""
    return {"position": rms(errors[:, :2]), "heading": float(np.rad2deg(rms(errors[:, 2:])))}
