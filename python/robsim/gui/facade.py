"""The public handle of a run's panel: `panel` opens one, `Panel` is its remote control."""

from __future__ import annotations

from concurrent import futures
from concurrent.futures import CancelledError, Future
from copy import deepcopy
from io import BytesIO
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from robsim._core import Step
from robsim.base.checks import Floats
from robsim.base.in_browser import check_has_threads
from robsim.base.text import quoted
from robsim.control.path_following import as_goals
from robsim.estimation.identification.batch import BatchEstimate
from robsim.gui._driver import SPEED, State
from robsim.gui.hosted import AT_EXIT, HostedPanel, lock, opened
from robsim.gui.panels.view import PanelView, Shown
from robsim.simulation import Simulation
from robsim.trace import Trace
from robsim.trace.sessions.session import Session
from robsim.vision.imaging import images

if TYPE_CHECKING:
    from robsim.gui.tools.colors.panel import ColorPanel
    from robsim.gui.tools.robots.panel import RobotPanel
    from robsim.teach.tasks import Task


_PATIENCE = 0.5  # s with a command, before checking whether it can ever end


def panel(
    what: Shown,
    *,
    speed: float | None = None,
    goals: ArrayLike | None = None,
    task: Task | None = None,
) -> Panel:
    """Open the panel of a run: camera view, controls, traces, callbacks.

    In a notebook, a panel in the last line of a cell is displayed, and runs alongside other cells.
    In a script, `Panel.open` shows the panel in a browser window; in a shell, ``robsim gui`` does.

    Parameters
    ----------
    what : Simulation, Experiment, Recording, Trace or Session
        The run to show. The panel owns a simulation or an experiment until the panel is closed:
        pause before you look at its frames or change it. The panel stops a callback after 30 s,
        unless the run has a `time_limit`. In a recording, the panel measures the pose frame by
        frame; a trace or a session is played back.
    speed : float, optional
        Multiple of real time, above 0; ``float("inf")`` = as fast as possible. A live camera sets
        its own speed. Default: the current speed if `what` has an open panel, otherwise 5.
    goals : array_like (2,), (3,) or (N, 2), optional
        The robot's goal, drawn in the picture of a new panel: a position, a pose, or the waypoints
        of a path (work-area px). Default: `goals` of the task.
    task : Task, optional
        The task of a simulation, such as of ``task.simulation()``: a new panel shows its score
        during the run, and the best score on this machine.

    Returns
    -------
    Panel
        The panel. If `what` has an open panel, this panel is returned.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or is out of range; the message names it.
    RuntimeError
        If `what` is already running, for example in another thread.

    Notes
    -----
    A notebook needs ``pip install "robsim[notebook]"``. A saved notebook contains a recent picture
    of the panel, for readers without Python. JupyterLab and Jupyter Notebook 7 show the panel at
    full speed. Colab delivers a few pictures per second. VS Code loads a part of its widgets from
    the internet, after your permission. If the panel does not appear, ``panel.open()`` and
    ``robsim gui`` show it in a browser window.

    Examples
    --------
    In a notebook, as the last lines of a cell:

    >>> sim = robsim.Simulation(control=robsim.DriveAround(), measure=True, seed=1)
    >>> panel = robsim.panel(sim)
    >>> panel
    <robsim.gui.Panel: Simulation, paused at the start>

    In the next cell, while the panel is shown:

    >>> step = panel.step()
    >>> panel.trace.seen
    array([ True])
    >>> panel.save("panel.png")
    >>> panel.close()
    """
    asked = None if goals is None else as_goals(goals)
    if task is not None:
        _check_task(task, what)
    with lock:
        found = _panel_of(what)
        if found is None:
            found = Panel(what, SPEED if speed is None else speed, asked, task)
        elif speed is not None:
            found.speed = speed
        return found


def _check_task(task: Any, what: Any) -> None:
    from robsim.teach.tasks.definition import check_task

    check_task(task)
    if not isinstance(what, Simulation):
        raise TypeError(f"task requires a Simulation as `what`, got {quoted(what)}")


def is_shown(what: Shown) -> bool:
    with lock:
        return _panel_of(what) is not None


def _panel_of(what: Shown) -> Panel | None:
    panels = (one for one in opened if isinstance(one, Panel))
    return next((one for one in panels if one._what is what), None)


class Panel(HostedPanel):
    """The panel of a run; `robsim.panel` opens this panel.

    The methods have the same effects as the buttons, and return when the command is complete,
    between two steps. After `pause` you may look at the simulation and set its callbacks. Any
    thread may call the methods, and read `trace` during the run. The end of a ``with`` block closes
    the panel.

    Examples
    --------
    In a script, ``panel.open()`` shows the panel in a browser window, and ``panel.wait()`` waits
    until that window is closed. Without a window:

    >>> sim = robsim.Simulation(control=robsim.DriveAround(), measure=True, seed=1)
    >>> with robsim.panel(sim) as panel:
    ...     steps = [panel.step() for _ in range(3)]
    ...     print(len(panel.trace), panel.state)
    3 paused
    """

    _maker = "robsim.panel"
    _view: PanelView

    def __init__(
        self, what: Shown, speed: float, goals: Floats | None = None, task: Task | None = None
    ) -> None:
        check_has_threads("The panel")
        self._what = what
        self._view = PanelView(what, speed=speed, goals=goals, task=task)
        super().__init__()

    # Commands.

    def start(self) -> None:
        """Run until a pause, an error or the end."""
        self._do(self._view.driver.start())

    def pause(self) -> None:
        """Stop after the current step; in an experiment, also stop the robot."""
        if self.state != "closed":
            self._do(self._view.driver.pause())

    def step(self) -> Step:
        """Pause, and run one step.

        Returns
        -------
        Step
            The step.

        Raises
        ------
        Exception
            Any exception raised by a callback, as in `Simulation.step`.
        """
        self._do(self._view.driver.step())
        self._raise_error()
        return self.last_step

    def step_stage(self) -> str:
        """Pause, and run one stage of a step.

        Returns
        -------
        str
            The next stage.

        Raises
        ------
        Exception
            Any exception raised by a callback.
        """
        self._do(self._view.driver.step_stage())
        self._raise_error()
        return self._view.runner.stage

    def reset(self) -> None:
        """Pause, and return to the start."""
        self._do(self._view.driver.reset())
        self._raise_error()

    def finish(self) -> BatchEstimate:
        """Pause, and return `robsim.batch_estimate` of all steps; the panel shows table and figure.

        Raises
        ------
        ValueError
            If the robot was seen in too few steps.
        """
        self._check_open()
        self._view.finish()
        self.pause()
        return deepcopy(self._view.estimate())  # the caller may change the copy

    # State.

    @property
    def state(self) -> State:
        """``"paused"``, ``"running"``, ``"ended"`` (no more frames), ``"failed"``, ``"closed"``."""
        return self._view.driver.state

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the run if `state` is ``"failed"``."""
        return self._view.driver.error

    @property
    def speed(self) -> float:
        """Multiple of real time; inf = as fast as possible. Assign to change it."""
        return self._view.driver.speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._view.driver.speed = speed
        self._view.post(self._view.tell_state)

    @property
    def last_step(self) -> Step:
        """The newest step; pause before you look at its frame."""
        return self._view.driver.ask(lambda: self._view.runner.last_step)

    @property
    def trace(self) -> Trace:
        """All steps so far; the run may continue during this call."""
        return self._view.record.trace

    @property
    def tool(self) -> RobotPanel | ColorPanel | None:
        """The open tool of the panel, if Define Robot or Train Camera is active."""
        return self._view.tools.tool

    def save(self, path: str | PathLike[str]) -> None:
        """Write a picture of the camera view and the traces.

        Parameters
        ----------
        path : path
            The file to write, such as ``panel.png``.

        Raises
        ------
        OSError
            If the file cannot be written.
        TypeError, ValueError
            If `path` is not a path, or its suffix names no known format.
        """
        file, _ = images.image_file(path)  # drawing takes seconds
        images.save_image(file, np.asarray(Image.open(BytesIO(self.snapshot())).convert("RGB")))

    def __repr__(self) -> str:
        what, steps = type(self._what).__name__, self._view.record.n_steps
        where = f"at step {steps - 1}" if steps else "at the start"
        return f"<robsim.gui.Panel: {what}, {self.state} {where}>"

    # Internals.

    @property
    def _is_closed(self) -> bool:
        return self.state == "closed"

    @property
    def _is_saved(self) -> bool:
        """Whether the panel plays back a run from a file."""
        return isinstance(self._what, (Trace, Session))

    def _pause_soon(self, timeout: float = AT_EXIT) -> None:
        futures.wait([self._view.driver.pause()], timeout)  # a callback may hang

    def _do(self, command: Future[Any]) -> None:
        """Wait for a command; raise in a callback, because the command waits for the callback.

        TimeoutError: the command waits for a callback that cannot be ended.
        """
        if self._view.driver.is_here:
            return
        while not command.done() and futures.wait([command], _PATIENCE).not_done:
            if (why := self._view.stuck.hopeless(is_call=command.running())) is not None:
                raise TimeoutError(why)
        try:
            command.result()
        except CancelledError:
            self._check_open()
            raise

    def _raise_error(self) -> None:
        if self.error is not None and not self._view.driver.is_here:
            raise self.error
