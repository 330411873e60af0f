"""The simulation: scene, slots, callback folders, the loop."""

from robsim.simulation._scene import draw_red_square
from robsim.simulation._simulation import Simulation

__all__ = [
    "Simulation",
    "draw_red_square",
]
