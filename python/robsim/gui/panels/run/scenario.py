"""All options of a simulated world: changed now or at the next run, saved in files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from robsim.gui._link import Link, Refused
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.record import RunRecord
from robsim.gui.panels.settings.estimator import default_estimator
from robsim.gui.panels.settings.options import default_of, described, option_of
from robsim.gui.panels.settings.owners import owners_of
from robsim.gui.panels.settings.setting import Remarks
from robsim.gui.panels.settings.signals import SIGNAL_KINDS
from robsim.gui.panels.settings.stages import Stages
from robsim.simulation import Scenario, Simulation
from robsim.simulation.options import OPTIONS
from robsim.simulation.simulation import is_data
from robsim.simulation.slots import SLOTS
from robsim.simulation.world.world_of_scenario import check_bounces

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

_GAP = 0.5  # s between two looks at changes from elsewhere
_PLAIN = (Refused, TypeError, ValueError, OverflowError)  # errors in a value
_VISION = ("robot", "colors", "markers")
#: The options that may change between two steps.
_LIVE = {name for name, row in OPTIONS.items() if row.is_live or name in _VISION or name in SLOTS}


class ScenarioOptions(Part):
    """The options of a simulation; options that are fixed during a run wait for the next one."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        assert isinstance(panel.runner, Simulation)
        self._sim = panel.runner
        self._owners = owners_of(self._sim)
        self._stages = Stages(self._sim, self._owners)
        self._waiting: Mapping[str, Any] = {}  # replaced as a whole, in the thread of the run
        self._told: tuple[Any, ...] = ()
        self._due = 0.0
        panel.driver.on_reset.append(self._begin)

    def handlers(self) -> Handlers:
        return {
            "set_option": self._set,
            "keep_options": lambda link, message: self._do(link, None, self._forget),
            "load_scenario": self._load,
            "save_scenario": self._save,
        }

    def setup(self) -> dict[str, Any]:
        return {"has_options": True}

    def greet(self, link: Link) -> None:
        link.send(self._message())

    def look(self, now: float) -> float:
        if not self.panel.is_watched:
            return math.inf
        if now >= self._due:
            self._due = now + _GAP
            if self._state() != self._told:
                self.panel.send(self._message())
        return self._due

    def _state(self) -> tuple[Any, ...]:
        return self._sim.scenario, self._waiting, self._by_code()

    def _by_code(self) -> dict[str, str]:
        """Return the owner of the code in slots that are also options."""
        slots = self._sim._callbacks.items()
        code = [name for name, value in slots if name in OPTIONS and not is_data(name, value)]
        return {name: self._owners.of(name) for name in code}

    def _message(self) -> dict[str, Any]:
        self._told = scenario, waiting, by_code = self._state()
        wanted = scenario.replace(**waiting)
        if "seed" not in waiting and self._sim._scenario.seed is None:
            wanted = wanted.replace(seed=None)  # drawn, not chosen
        told = []
        for name, option in OPTIONS.items():
            entry = described(option, wanted) | {"live": name in _LIVE, "waits": name in waiting}
            if name in by_code and name not in waiting:
                entry |= {"form": "code", "fixed": True, "changed": True}
            told.append(entry)
        return {"type": "options", "options": told}

    def _set(self, link: Link, message: dict[str, Any]) -> None:
        name, data = message["name"], message["value"]
        self._do(link, name, lambda: self._change({name: option_of(name, data)}))

    def _load(self, link: Link, message: dict[str, Any]) -> None:
        def load() -> Remarks:
            loaded = Scenario.from_toml(message["text"])
            values = {name: getattr(loaded, name) for name in OPTIONS}
            return self._change(values, is_loaded=True)

        self._do(link, None, load)

    def _save(self, link: Link, message: dict[str, Any]) -> None:
        text = self._sim.scenario.replace(**self._waiting).to_toml()
        link.send({"type": "scenario_file", "text": text})
        if code := self._by_code().keys() - self._waiting:
            text = f"The file has no code: that for {', '.join(sorted(code))} is left out"
            link.send({"type": "note", "level": "info", "text": text})

    def _do(self, link: Link, name: str | None, change: Callable[[], Remarks]) -> None:
        """Change something between two steps; show an error next to its field."""
        self.change(link, change, self._changed, _PLAIN, option=name)

    def _changed(self) -> None:
        self.panel.send(self._message())
        self.panel.tell_state()

    # In the thread of the run.

    def _change(self, changes: Mapping[str, Any], *, is_loaded: bool = False) -> Remarks:
        """Change options; a file applies as a whole, at the next run."""
        sim, driver, before = self._sim, self.panel.driver, self._waiting
        wanted = sim.scenario.replace(**{**before, **changes})
        check_bounces(wanted)
        waiting, remarks, by_code = {**before}, [], self._by_code()
        for name in changes:
            value = getattr(wanted, name)
            waiting.pop(name, None)
            if self._has(name, value, by_code, is_loaded):
                continue
            if name in _LIVE and not is_loaded:
                remarks += self._change_now(name, value)
            else:
                waiting[name] = value
        self._waiting = waiting
        self._stages.tune()
        if waiting and not sim.n_steps and driver.state != "running":
            try:
                driver._reset()
            except BaseException:
                self._waiting = before
                raise
        return remarks

    def _has(self, name: str, value: Any, by_code: Mapping[str, str], is_loaded: bool) -> bool:
        """Return whether an option has the wanted value; a file leaves callbacks in their slots."""
        if name in by_code:
            return is_loaded and by_code[name] == "mine" and value == default_of(name)
        return bool(getattr(self._sim.scenario, name) == value)

    def _change_now(self, name: str, value: Any) -> Remarks:
        sim = self._sim
        if isinstance(value, bool):
            return self._stages.choose(name, "default" if value else "off")
        if name in SLOTS:
            put = self._owners.put if type(value) in (*SIGNAL_KINDS, type(None)) else sim._choose
            return self._stages.change(name, lambda: put(name, value))
        if name in _VISION:
            sim._change_vision(**{name: value})
        else:
            setattr(sim, name, value)
        return []

    def _forget(self) -> Remarks:
        self._waiting = {}
        return []

    def _begin(self) -> None:
        """Begin the run with the waiting options; restore everything if that fails."""
        if not (waiting := self._waiting):
            return
        sim, owners, before = self._sim, self._owners, {**vars(self._sim)}
        scenario = sim.scenario.replace(**waiting)
        slots = {*sim.SLOTS} - {*waiting}
        kept = {slot for slot in slots if owners.of(slot) == "mine" or owners.is_made(slot)}
        try:
            remarks = self._stages.change("estimate_parameters", lambda: sim._renew(scenario, kept))
            if owners.is_made("estimate_state") and sim._is_on("estimate_state"):
                owners.put("estimate_state", default_estimator(sim))
        except BaseException:
            vars(sim).update(before)
            raise
        self._waiting = {}
        for remark in remarks:
            self.panel.note(remark, "info")
        self.panel.post(self._renewed)

    def _renewed(self) -> None:
        if isinstance(self.panel.record, RunRecord):
            self.panel.record.look_again()
        self.panel.tell_setup()
        self.panel.send(self._message())
