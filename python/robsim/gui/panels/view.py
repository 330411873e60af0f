"""The main panel: its parts, and their shared data."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from robsim._core import Step
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.estimation.identification.batch import BatchEstimate
from robsim.gui._driver import SPEED, Driver, Playback
from robsim.gui._link import Link, Messages, Refused
from robsim.gui._view import RETRY, View
from robsim.gui.panels.analysis.ghosts import Ghosts
from robsim.gui.panels.analysis.inspector import Inspector
from robsim.gui.panels.analysis.past import Past
from robsim.gui.panels.analysis.result import Parameters, Result
from robsim.gui.panels.analysis.rows import Rows
from robsim.gui.panels.analysis.statistics import Statistics
from robsim.gui.panels.part import MESSAGES, Handlers, Part
from robsim.gui.panels.record import ExperimentRecord, Record, SavedRecord, SimulationRecord
from robsim.gui.panels.run.callbacks import Callbacks
from robsim.gui.panels.run.camera import CameraView
from robsim.gui.panels.run.challenge import Challenge
from robsim.gui.panels.run.controls import Controls
from robsim.gui.panels.run.scenario import ScenarioOptions
from robsim.gui.panels.run.share import Share
from robsim.gui.panels.run.stuck import Stuck
from robsim.gui.panels.run.tools import Tools
from robsim.gui.panels.run.transport import Transport
from robsim.gui.panels.still_part import Still
from robsim.simulation import Experiment, Simulation
from robsim.trace import Trace
from robsim.trace.sessions.session import Session
from robsim.vision.imaging.recordings import Recording

if TYPE_CHECKING:
    from robsim.teach.tasks import Task

_MOST_COMMANDS = 100  # from browsers, waiting for the run, such as while a callback hangs
_PATIENCE = 2.0  # s for a reloaded page to reconnect

Shown = Simulation | Experiment | Recording | Trace | Session


class PanelView(View):
    """Camera view, controls, traces and callbacks of a run or a saved run."""

    kind: ClassVar[str] = "panel"
    messages: ClassVar[Messages] = MESSAGES

    def __init__(
        self,
        shown: Shown,
        *,
        speed: float = SPEED,
        goals: Floats | None = None,
        task: Task | None = None,
    ) -> None:
        super().__init__()
        self.goals = task.goals if goals is None and task is not None else goals
        #: Returns to the start page, if the panel was opened there; in the thread of the view.
        self.go_home: Callable[[], None] | None = None
        self.runner, self.record = _runner_and_record(shown)
        self.driver = Driver(self.runner, speed=speed)
        self._alone_at = math.inf  # when to pause the run for lack of views
        self._was_running = self._is_change_waiting = False
        self.rows, self.past, self._result = Rows(self), Past(self), Result(self)
        self.camera, self.still, self.stuck = CameraView(self), Still(self), Stuck(self)
        kinds = [Transport, Controls, Statistics, Parameters, Inspector, Ghosts]
        self.share = Share(self)
        if not isinstance(self.runner, Playback):
            kinds.append(Callbacks)
        if isinstance(self.runner, Simulation):
            kinds.append(ScenarioOptions)
        made = (kind(self) for kind in kinds)
        self.tools = Tools(self)
        analysis = (
            self.past,
            self._result,
            self.still,
            self.rows,
            self.stuck,
            self.tools,
            self.share,
        )
        self._parts: list[Part] = [self.camera, *made, *analysis]
        if task is not None:
            self._parts.append(Challenge(self, task))
        self._handlers = {**super().handlers()}
        for part in self._parts:
            self._handlers |= part.handlers()
        self.driver.on_step.append(self._take)
        self.driver.on_state.append(self._tell_browsers)

    @property
    def is_running(self) -> bool:
        return self.driver.state == "running"

    def finish(self) -> None:
        """Pause, and send the batch estimate of all recorded steps to all browsers."""
        paused = self.driver.pause()
        paused.add_done_callback(lambda _: self.post(self._result.tell))

    def estimate(self) -> BatchEstimate:
        """Return the batch estimate of all recorded steps; ValueError if there is no estimate."""
        return self._result.estimate()

    def close(self, timeout: float = 5.0) -> bool:
        """End the run and the panel; the page keeps its last state. False if a callback hangs."""
        has_ended = self.driver.close(timeout)
        if not has_ended and self.driver.limit is not None:
            self.driver.limit.end("the panel was closed", self.driver.limit.call)
            has_ended = self.driver.close(min(timeout, _PATIENCE))
        has_ended = super().close(timeout) and has_ended
        for part in self._parts:
            part.close(timeout)
        return has_ended

    def settle(self) -> None:
        super().settle()
        if not (self.is_here or self.driver.is_here):  # a callback, which the run waits for
            self.driver.ask(lambda: None)
            super().settle()  # the answers of the run
            self.tools.settle()
            self._result.settle()
            super().settle()  # the messages about the result

    def is_urgent(self, message: Any) -> bool:
        return (
            isinstance(message, dict)
            and message.get("type") == "press"
            and message.get("button") == "stop"
        )

    def snapshot(self) -> bytes:
        return self.still.picture()

    # In the thread of the run.

    def _take(self, step: Step) -> None:
        for part in self._parts:
            self.guarded(part.take, step)
        if not self.is_running:
            self._tell_change()

    def _tell_browsers(self, driver: Driver) -> None:
        was_running, self._was_running = self._was_running, driver.state == "running"
        is_over = (was_running and not self._was_running) or driver.state == "failed"
        last = None
        if is_over and self.record.n_steps:  # during the run it may have been skipped
            last = self.guarded(lambda: self.runner.last_step)
        if last is None:
            self._tell_change()
        else:
            self._take(last)

    def _tell_change(self) -> None:
        if not self._is_change_waiting:  # one message for several changes
            self._is_change_waiting = True
            self.post(self._changed)

    # In the thread of the view.

    def handlers(self) -> Handlers:
        return self._handlers

    def look(self, now: float) -> float:
        due = self._look_for_watchers(now)
        for part in self._parts:
            next_due = self.guarded(part.look, now)
            due = min(due, now + RETRY if next_due is None else next_due)
        return due

    def has_room(self, factor: int = 1) -> bool:
        """Return whether the run can take a command: fewer than `factor` times the limit wait."""
        return self.driver.n_waiting < factor * _MOST_COMMANDS

    def check_room(self, factor: int = 1) -> None:
        if not self.has_room(factor):
            raise Refused("The run does not answer: a callback is still busy")

    def farewell(self, last: Link) -> None:
        last.rows = dict.fromkeys(self.record.columns(), 0)
        if self.driver.state == "closed":  # otherwise a callback hangs within the step
            self.camera.renew()

    def tell_setup(self) -> None:
        self.send(self._gathered("setup"))

    def tell(self, link: Link) -> None:
        link.send(self._gathered("setup"))
        link.send(self._gathered("state"))
        for part in self._parts:
            self.guarded(part.greet, link)

    def tell_state(self) -> None:
        self.send(self._gathered("state"))

    def parted(self) -> None:
        """Pause without views, after a delay because a reloaded page also disconnects.

        A real robot stops at once: without a view, the user cannot press Stop.
        """
        self._alone_at = time.monotonic() + (0.0 if self.driver.has_motors else _PATIENCE)

    def _look_for_watchers(self, now: float) -> float:
        if self.is_watched:
            self._alone_at = math.inf
        if now >= self._alone_at:
            self._alone_at = math.inf
            is_moving = self.is_running or self.driver.n_waiting  # such as a start
            if is_moving and self.driver.has_motors:
                self.guarded(self.driver.stop_robot)
            elif is_moving:
                self.driver.pause()
        return self._alone_at

    def _gathered(self, kind: str) -> Mapping[str, Any]:
        """Return a message to which each part adds its fields."""
        message: dict[str, Any] = {"type": kind}
        for part in self._parts:
            message |= self.guarded(part.setup if kind == "setup" else part.state) or {}
        return message

    def _changed(self) -> None:
        self._is_change_waiting = False
        for part in self._parts:
            self.guarded(part.changed)
        self.tell_state()


def _runner_and_record(shown: Shown) -> tuple[Simulation | Experiment | Playback, Record]:
    if isinstance(shown, (Simulation, Experiment)) and shown.is_running:
        raise RuntimeError(
            "a panel must start its run, but this run is already running: wait for its end, or "
            "call stop()"
        )
    if isinstance(shown, Simulation):
        return shown, SimulationRecord(shown)
    if isinstance(shown, Recording):
        shown = Experiment(shown)
    if isinstance(shown, Experiment):
        return shown, ExperimentRecord(shown)
    if isinstance(shown, (Trace, Session)):
        record = SavedRecord(shown)
        return Playback(record), record
    raise TypeError(
        "`what` must be a Simulation, an Experiment, a Recording, a Trace or a Session, got "
        f"{quoted(shown)}"
    )
