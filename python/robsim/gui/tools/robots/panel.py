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
    """The panel that defines a robot; `robsim.gui.robot_panel` makes it.

    What its mouse does can be done by its methods, from any thread. A context closes it at its end;
    what it looked at stays open.
    """

    _maker = "robsim.gui.robot_panel"
    _view: RobotsView

    @property
    def value(self) -> RobotDefinition:
        """The robot as it is drawn now; a ValueError says what is missing. It can be set."""
        return self._look(self._view.definition)

    @value.setter
    def value(self, robot: str | PathLike[str] | RobotDefinition) -> None:
        definition = as_robot(robot)
        self._view.ask(lambda: self._view.load(definition))

    def load(self, picture: Frame | images.Pixels | str | PathLike[str]) -> None:
        """Take a picture, as if it were dropped on the tool.

        One whose surroundings are transparent is drawn on at once, with first guesses; another one
        is shown in place of the live picture, and `capture` takes the robot out of it.

        Parameters
        ----------
        picture : path, Frame or array (H, W, 3) or (H, W, 4) of uint8
            The picture. What is drawn on is scaled down to at most 1000 px a side.

        Raises
        ------
        OSError
            If the file cannot be read.
        RuntimeError
            If the panel is closed.
        TypeError, ValueError
            If it is no picture, or transparent everywhere; nothing is changed then.
        """
        super().load(picture)

    def capture(self, *, whole: bool = False) -> None:
        """Draw on what the square of the live or loaded picture shows, with first guesses.

        It is scaled down to at most 1000 px a side.

        Parameters
        ----------
        whole : bool
            Take all of the picture instead.

        Raises
        ------
        TypeError
            If `whole` is neither True nor False.
        ValueError
            If there is no such picture.
        """
        check_bool("whole", whole)
        self._view.ask(lambda: self._view.capture(whole=whole))

    def draw(self, part: str, polygon: ArrayLike) -> None:
        """Draw a polygon.

        Parameters
        ----------
        part : str
            ``"outline"``, or the colour of a marker: ``"red"``, ``"blue"`` or what they are.
        polygon : array (N, 2)
            Its corners (image px): right, down.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape; nothing is changed then.
        """
        self._change(lambda: self._view.drawing.put(part, polygon))

    def turn(self, degrees: float) -> None:
        """Turn the picture against the heading.

        Parameters
        ----------
        degrees : float
            Clockwise rotation that is added (degrees).

        Raises
        ------
        TypeError, ValueError
            If it is no number.
        """
        self._change(lambda: self._view.drawing.turn(degrees))

    def save(self, name: str, *, overwrite: bool = False) -> RobotDefinition:
        """Add the robot to your own, where it survives a restart.

        Parameters
        ----------
        name : str
            Its name, which no robot that ships has.
        overwrite : bool
            Replace your robot of this name, if there is one.

        Returns
        -------
        RobotDefinition
            The robot.

        Raises
        ------
        TypeError, ValueError
            If the name is not valid or taken, or the robot is not complete.
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
