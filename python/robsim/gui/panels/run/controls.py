"""The controls of a run: stages, controller, world, speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from robsim.base.checks import Floats
from robsim.gui._driver import Playback
from robsim.gui._link import Link, Refused
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.settings.driving import Driving, as_told
from robsim.gui.panels.settings.owners import owners_of
from robsim.gui.panels.settings.setting import Remarks, Setting
from robsim.gui.panels.settings.speed import Speed
from robsim.gui.panels.settings.stages import Stage, Stages
from robsim.gui.panels.settings.world import world_settings
from robsim.simulation import Experiment, Simulation

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

_GAP = 0.5  # s between two looks for changes from elsewhere, such as a cell


class _Run:
    """The controls of one run."""

    def __init__(self, runner: Simulation | Experiment, goals: Floats | None) -> None:
        self.runner = runner
        self.owners = owners_of(runner)
        self.stages = Stages(runner, self.owners)
        self.driving = Driving(runner, self.stages, self.owners, goals)

    def settings(self) -> list[Setting]:
        """Return the controls in their order."""
        world = [] if isinstance(self.runner, Experiment) else world_settings(self.runner)
        return [
            Stage("tracking", "measure", self.stages, self.owners),
            Stage("parameters", "estimate_parameters", self.stages, self.owners),
            Stage("state", "estimate_state", self.stages, self.owners),
            self.driving,
            *world,
        ]


class Controls(Part):
    """Sends the available controls, and applies changes in the thread of the run."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        settings: list[Setting] = []
        self._run: _Run | None = None
        if not isinstance(panel.runner, Playback):
            self._run = _Run(panel.runner, panel.goals)
            settings += self._run.settings()
        if not (isinstance(panel.runner, Experiment) and panel.runner.is_live):
            settings.append(Speed(panel.driver))  # a camera sets its own speed
        self._settings = {setting.name: setting for setting in settings}
        self._limits_told = self._limits()
        self._state_told: dict[str, Any] = {}
        self._due = 0.0

    def handlers(self) -> Handlers:
        return {"set": self._set, "go_to": self._go_to, "path": self._path}

    def setup(self) -> dict[str, Any]:
        controls = [setting.described() for setting in self._settings.values()]
        asked, _ = as_told(goals := self.panel.goals)
        return {"controls": controls, "has_goals": goals is not None, "asked": asked}

    def state(self) -> dict[str, Any]:
        values = {name: setting.value for name, setting in self._settings.items()}
        driving = self._run and self._run.driving
        goal, path = (driving.goal, driving.path) if driving else as_told(self.panel.goals)
        return {"values": values, "goal": goal, "path": path}

    def look(self, now: float) -> float:
        if not any(link.is_watched for link in self.panel.links):
            return math.inf
        if now >= self._due:
            self._due = now + _GAP
            if self._run is not None:
                self._run.owners.look()
            self._tell_changes()
        return self._due

    def _set(self, link: Link, message: dict[str, Any]) -> None:
        if (setting := self._settings.get(message["name"])) is None:
            raise Refused(f"unknown control {message['name']!r}")
        self._do(link, message, lambda: setting.set(message["value"]))

    def _go_to(self, link: Link, message: dict[str, Any]) -> None:
        driving = self._driving()
        self._do(link, message, lambda: driving.go_to(message["x"], message["y"]))

    def _path(self, link: Link, message: dict[str, Any]) -> None:
        driving = self._driving()
        self._do(link, message, lambda: driving.follow(message["points"]))

    def _driving(self) -> Driving:
        if self._run is None:
            raise Refused("this is a recorded run: its robot cannot be driven")
        return self._run.driving

    def _do(self, link: Link, message: dict[str, Any], change: Callable[[], Remarks]) -> None:
        """Change something between two steps, and report the outcome."""

        def change_all() -> Remarks:
            remarks = change()
            if self._run is not None:
                self._run.stages.tune()
            return remarks

        self.change(link, lambda: self.panel.share.noted(message, change_all), self._changed)

    def _changed(self) -> None:
        self._state_told = {}  # the view shows its request, which may be refused
        self._tell_changes()

    def _tell_changes(self) -> None:
        limits, state = self._limits(), self.state()
        if limits != self._limits_told:
            self.panel.tell_setup()
        if state != self._state_told:
            self.panel.tell_state()
        self._limits_told, self._state_told = limits, state

    def _limits(self) -> dict[str, Any]:
        return {name: setting.limits() for name, setting in self._settings.items()}
