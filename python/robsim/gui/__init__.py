"""The face: panels of a run in a notebook, or in a browser window of their own."""

from robsim.base.doors import present as _present
from robsim.gui.facade import Panel, panel
from robsim.gui.tools.colors.panel import ColorPanel, color_panel
from robsim.gui.tools.floor.panel import FloorPanel, floor_panel
from robsim.gui.tools.robots.panel import RobotPanel, robot_panel

__all__ = [
    "ColorPanel",
    "FloorPanel",
    "Panel",
    "RobotPanel",
    "color_panel",
    "floor_panel",
    "panel",
    "robot_panel",
]

_present(globals())
