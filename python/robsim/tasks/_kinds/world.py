"""What the worlds of the tasks have in common: small frames, noise, dropouts, disturbances."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from robsim._base.text import quoted
from robsim._core import RobotModel
from robsim.imaging import GaussianNoise
from robsim.simulation import Dropout, ParameterMismatch, Scenario, WheelNoise
from robsim.trace import Trace
from robsim.trace._trace import check_trace

#: Work area and frame (px): a ninth of the pixels, so that many runs are quick.
AREA, RESOLUTION = (1200, 1200), (400, 400)

#: A smaller area, so that a robot comes to a goal within some 100 steps.
DRIVING_AREA, DRIVING_RESOLUTION = (640, 640), (320, 320)

#: Time of a step (s).
DT = RobotModel().dt

#: What a motor may get (V); without a limit larger voltages are faster, beyond any motor.
MAXIMUM_VOLTAGE = 1.0

#: How long the robot is hidden at a time (steps).
_HIDDEN_STEPS = 3

#: What disturbs the voltages of the motors in each step.
_PROCESS_NOISE = WheelNoise(0.1)

#: How near to a wall a robot does not come (px): its radius, and some room.
_WALL = 80

_ROUNDING = 1e-9  # V


def camera_noise(percent: float) -> GaussianNoise | None:
    return GaussianNoise(percent) if percent > 0 else None


def dropout_of(probability: float) -> Dropout | None:
    return Dropout(probability, steps=_HIDDEN_STEPS) if probability > 0 else None


def driving_world(*, noise: float, dropout: float, mismatch: float) -> Scenario:
    """Return a world in which a controller is given measured poses, and the model is not exact."""
    return Scenario(
        robot="lab",
        area=DRIVING_AREA,
        resolution=DRIVING_RESOLUTION,
        headings=None,
        start="random",
        noise=camera_noise(noise),
        dropout=dropout_of(dropout),
        process_noise=_PROCESS_NOISE,
        mismatch=ParameterMismatch(mismatch) if mismatch > 0 else None,
        measure=True,
    )


def check_inside(name: str, positions: Iterable[Sequence[float]]) -> None:
    """Raise ValueError unless a robot can drive to all positions in `DRIVING_AREA`."""
    for position in positions:
        if any(
            not _WALL <= x <= side - _WALL for x, side in zip(position, DRIVING_AREA, strict=True)
        ):
            raise ValueError(
                f"{name} must be at least {_WALL} px from the walls of the area, "
                f"{' x '.join(map(str, DRIVING_AREA))} px, got {quoted(tuple(position))}"
            )


def voltage_beyond_limit(trace: Trace) -> str | None:
    """Return a sentence on the first voltage above `MAXIMUM_VOLTAGE`; None = there is none."""
    check_trace(trace)
    largest = np.abs(trace.u).max(axis=1)
    rows = np.flatnonzero(largest > MAXIMUM_VOLTAGE + _ROUNDING)
    if not len(rows):
        return None
    return (
        f"{largest[rows[0]]:.3g} V at step {trace.k[rows[0]]}: a motor must not get more than "
        f"{MAXIMUM_VOLTAGE:g} V"
    )
