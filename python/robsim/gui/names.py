"""The public names of the GUI. The first use loads everything; the start page does not."""

from robsim.gui.facade import Panel, panel
from robsim.gui.replays import replay
from robsim.gui.tools.colors.panel import ColorPanel
from robsim.gui.tools.floor.panel import FloorPanel
from robsim.gui.tools.opening import color_panel, floor_panel, robot_panel
from robsim.gui.tools.robots.panel import RobotPanel

__all__ = [
    "ColorPanel",
    "FloorPanel",
    "Panel",
    "RobotPanel",
    "color_panel",
    "floor_panel",
    "panel",
    "replay",
    "robot_panel",
]
