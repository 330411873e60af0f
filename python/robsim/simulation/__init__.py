"""The simulation: its options, slots and loop, the scene, callback folders, frame sources."""

from robsim._base.public import present as _present
from robsim._core import (
    Estimate,
    Observation,
    Renderer,
    RobotModel,
    RobotParameters,
    Step,
    Unicycle,
    WorldState,
)
from robsim.simulation._disturbances import ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation._dropout import Dropout
from robsim.simulation._experiment import Experiment
from robsim.simulation._scenario import Scenario
from robsim.simulation._scene import draw_red_square
from robsim.simulation._simulation import Simulation

__all__ = [
    "Dropout",
    "Estimate",
    "Experiment",
    "Observation",
    "ParameterMismatch",
    "PoseNoise",
    "Renderer",
    "RobotModel",
    "RobotParameters",
    "Scenario",
    "Simulation",
    "Step",
    "Unicycle",
    "WheelNoise",
    "WorldState",
    "draw_red_square",
]

_present(globals())
