"""The simulation: its options, slots and loop, the scene, callback folders, frame sources."""

from robsim._core import (
    Estimate,
    Observation,
    Renderer,
    RobotModel,
    RobotParameters,
    Scene,
    Step,
    Unicycle,
    WorldState,
)
from robsim.simulation.callbacks.errors import (
    CallbackError,
    CallbackTypeError,
    CallbackValueError,
    FailedCallback,
)
from robsim.simulation.experiment import Experiment
from robsim.simulation.scenario import Scenario
from robsim.simulation.simulation import Simulation
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import draw_red_square

__all__ = [
    "CallbackError",
    "CallbackTypeError",
    "CallbackValueError",
    "Dropout",
    "Estimate",
    "Experiment",
    "FailedCallback",
    "Observation",
    "ParameterMismatch",
    "PoseNoise",
    "Renderer",
    "RobotModel",
    "RobotParameters",
    "Scenario",
    "Scene",
    "Simulation",
    "Step",
    "Unicycle",
    "WheelNoise",
    "WorldState",
    "draw_red_square",
]
