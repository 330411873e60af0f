"""`RobotPanel`: the users' side of the panel that defines a robot."""

from __future__ import annotations

from os import PathLike

from numpy.typing import ArrayLike

from robsim._core import Frame
from robsim.base.checks import check_bool
from robsim.gui.tools.panel import ToolPanel
from robsim.gui.tools.robots.view import RobotsView
from robsim.vision.imaging import images
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot


class RobotPanel(ToolPanel):
    """The panel that defines a robot; `robsim.gui.robot_panel` opens this panel.

    The methods have the same effects as the mouse, and any thread may call them. The end of a
    ``with`` block closes the panel, but not the camera or run that supplies the pictures.

    Examples
    --------
    >>> panel = robsim.gui.robot_panel()
    >>> panel.value.name
    'lab'
    >>> panel.close()
    """

    _maker = "robsim.gui.robot_panel"
    _view: RobotsView

    @property
    def value(self) -> RobotDefinition:
        """The robot in the drawing; ValueError if it is incomplete. Assign to set it."""
        return self._look(self._view.definition)

    @value.setter
    def value(self, robot: str | PathLike[str] | RobotDefinition) -> None:
        definition = as_robot(robot)
        self._view.ask(lambda: self._view.load(definition))

    def load(self, picture: Frame | images.Pixels | str | PathLike[str]) -> None:
        """Load a picture, as if it were dropped on the tool.

        If the surroundings of the robot are transparent, the drawing starts from this picture
        immediately, with initial guesses. Otherwise the picture replaces the live picture, and
        `capture` cuts out the robot.

        Parameters
        ----------
        picture : path, Frame or array (H, W, 3) or (H, W, 4) of uint8
            The picture. The drawing scales the picture down to at most 1000 px a side.

        Raises
        ------
        OSError
            If the file cannot be read.
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If the picture is invalid, or transparent everywhere; nothing changes.
        """
        super().load(picture)

    def capture(self, *, whole: bool = False) -> None:
        """Start a drawing, with initial guesses, from the square in the live or loaded picture.

        The picture is scaled down to at most 1000 px a side.

        Parameters
        ----------
        whole : bool
            Use the whole picture instead of the square.

        Raises
        ------
        TypeError
            If `whole` is neither True nor False.
        ValueError
            If there is no live or loaded picture.
        """
        check_bool("whole", whole)
        self._view.ask(lambda: self._view.capture(whole=whole))

    def draw(self, part: str, polygon: ArrayLike) -> None:
        """Draw a polygon.

        Parameters
        ----------
        part : str
            ``"outline"``, or the colour of a marker, such as ``"red"`` or ``"blue"``.
        polygon : array (N, 2)
            Its corners (image px): x to the right, y down.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape; nothing changes.
        """
        self._change(lambda: self._view.drawing.put(part, polygon))

    def turn(self, degrees: float) -> None:
        """Rotate the picture relative to the heading.

        Parameters
        ----------
        degrees : float
            Additional clockwise rotation (degrees).

        Raises
        ------
        TypeError, ValueError
            If `degrees` is not a number.
        """
        self._change(lambda: self._view.drawing.turn(degrees))

    def save(self, name: str, *, overwrite: bool = False) -> RobotDefinition:
        """Save the robot to the user's robots, which survive a restart.

        Parameters
        ----------
        name : str
            Its name, which no shipped robot may have.
        overwrite : bool
            Replace your robot of this name, if there is one.

        Returns
        -------
        RobotDefinition
            The robot.

        Raises
        ------
        TypeError, ValueError
            If the name is invalid or taken, or the robot is incomplete.
        """
        check_bool("overwrite", overwrite)
        return self._view.ask(lambda: self._view.save(name, overwrite=overwrite))

    def __repr__(self) -> str:
        problems = self._view.drawing.sketch.problems()
        return f"<robsim.gui.RobotPanel: {self._view.name}{', incomplete' * bool(problems)}>"

    def _made(self) -> tuple[str, RobotDefinition]:
        return "robot", self._view.named()

    def _keep(self) -> str:
        return self._view.keep()
