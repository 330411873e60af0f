"""The common part of driving tasks: their world, its disturbances, and a rule."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np

from robsim._core import RobotModel
from robsim.base.checks import Floats, check_float
from robsim.base.text import quoted
from robsim.simulation import Dropout, ParameterMismatch, Scenario, WheelNoise
from robsim.teach.tasks.definition import Task
from robsim.trace import Trace
from robsim.trace.trace import check_trace
from robsim.vision.imaging.noise import GaussianNoise

#: Work area and frame (px): a ninth of the pixels, so that many runs are quick.
AREA, RESOLUTION = (1200, 1200), (400, 400)
#: Time of a step (s).
DT = RobotModel().dt
#: The duration of a hiding of the robot (steps).
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
    """Return the rms length of rows; NaN without rows."""
    return float(np.sqrt(np.mean((rows**2).sum(axis=1)))) if len(rows) else float("nan")


def rms_of_poses(errors: Floats) -> dict[str, float]:
    """Return the rms of pose errors (N, 3): of the position (px), of the heading (degrees)."""
    return {"position": rms(errors[:, :2]), "heading": float(np.rad2deg(rms(errors[:, 2:])))}


#: Maximum voltage of a motor (V); without a limit larger voltages are faster, beyond any motor.
MAXIMUM_VOLTAGE = 1.0
#: Work area and frame (px): small, so that a robot comes to a goal within some 100 steps.
_AREA, _RESOLUTION = (640, 640), (320, 320)
#: The disturbance of the motor voltages in each step.
_PROCESS_NOISE = WheelNoise(0.1)
#: The minimum distance of a robot from a wall (px): its radius, and some room.
_WALL = 80
_ROUNDING = 1e-9  # V


class DrivingTask(Task):
    """A drive by measured poses, with an inexact model.

    Not a dataclass: its options are fields of the tasks, after their own fields.
    """

    slots: ClassVar[tuple[str, ...]] = ("control",)
    given: ClassVar[str] = "pose"

    noise: float
    dropout: float
    mismatch: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("noise", self.noise, "%", minimum=0, maximum=100)
        check_float("dropout", self.dropout, minimum=0, maximum=1)
        check_float("mismatch", self.mismatch, minimum=0, maximum=0.3)

    @property
    def scenario(self) -> Scenario:
        """The world of its runs: another start in each."""
        return small_world(
            area=_AREA,
            resolution=_RESOLUTION,
            headings=None,
            noise=self.noise,
            dropout=self.dropout,
            process_noise=_PROCESS_NOISE,
            mismatch=ParameterMismatch(self.mismatch) if self.mismatch > 0 else None,
        )

    def broken_rule(self, trace: Trace) -> str | None:
        """Return a sentence on the step with too large a voltage."""
        check_trace(trace)
        largest = np.abs(trace.u).max(axis=1)
        rows = np.flatnonzero(largest > MAXIMUM_VOLTAGE + _ROUNDING)
        if not len(rows):
            return None
        return (
            f"{largest[rows[0]]:.3g} V at step {trace.k[rows[0]]}: a motor must not get more than "
            f"{MAXIMUM_VOLTAGE:g} V"
        )


def check_inside(name: str, positions: Iterable[Sequence[float]]) -> None:
    for position in positions:
        if any(not _WALL <= x <= side - _WALL for x, side in zip(position, _AREA, strict=True)):
            raise ValueError(
                f"{name} must be at least {_WALL} px from the walls of the area of "
                f"{' x '.join(map(str, _AREA))} px, got {quoted(tuple(position))}"
            )
