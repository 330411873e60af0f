"""The stages of a step: off, robsim's own, or the user's, with their requirements."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from robsim.gui._link import Refused
from robsim.gui.panels.settings.estimator import default_estimator, tune, why_no_default
from robsim.gui.panels.settings.owners import Owners
from robsim.gui.panels.settings.setting import Choice, Remarks
from robsim.gui.panels.settings.signals import OFF, SIGNALS
from robsim.simulation import Experiment, Simulation
from robsim.simulation.callbacks.missing_data import needed_slots
from robsim.simulation.slots import SLOTS, STAGES

# The slots that the panel fills.

_SOURCES = {"measurement": "measure", "estimate": "estimate_state"}  # of the poses in samples


class Stages:
    """Fills slots so that the run can continue; only `choices` may run in other threads."""

    def __init__(self, runner: Simulation | Experiment, owners: Owners) -> None:
        self._runner = runner
        self._owners = owners

    def choose(self, slot: str, owner: str) -> Remarks:
        """Fill a slot: ``"off"``, ``"default"`` or ``"mine"``."""
        return self.change(slot, lambda: self._put(slot, owner))

    def fill(self, slot: str, value: Any) -> Remarks:
        """Fill a slot with a value of the panel."""
        return self.change(slot, lambda: self._owners.put(slot, value))

    def change(self, slot: str, put: Callable[[], None]) -> Remarks:
        """Fill a slot, switch on its requirements, and switch off slots that lack one now.

        If the run could not continue, all slots keep their values.
        """
        had_problem = self._problem() is not None
        was_lacking = self._all_lacking()  # frames may also bring the needs of a slot
        put_back = self._owners.kept(STAGES)
        try:
            put()
            remarks = [*self._switch_on(slot), *self._switch_off(was_lacking)]
            problem = self._problem()
            if problem is not None and not had_problem:
                raise Refused(problem)
        except BaseException:
            put_back()
            raise
        return remarks

    def tune(self) -> None:
        """Adapt the panel's state estimator to the current world."""
        if self._owners.is_made("estimate_state") and self._runner._is_on("estimate_state"):
            tune(self._runner._callbacks["estimate_state"], self._runner)

    def _put(self, slot: str, owner: str) -> None:
        if owner == "mine":
            self._owners.put_mine(slot)
        elif owner == "off":
            self._owners.put(slot, False)
        elif slot == "estimate_state":
            self._owners.put(slot, default_estimator(self._runner))
        else:
            self._owners.put(slot, True)

    def _switch_on(self, slot: str) -> Remarks:
        """Switch on the missing requirements of a slot, and their requirements."""
        remarks = []
        for lacking in self._lacking(slot):
            who, what = SLOTS[slot].title, SLOTS[lacking].title
            if lacking == "control":
                raise Refused(f"{who} needs the inputs of the robot: choose a controller")
            self._put(lacking, "default" if self._owners.why_not_mine(lacking) else "mine")
            remarks += [_sentence(f"{what} is on, too: {who} needs it"), *self._switch_on(lacking)]
        return remarks

    def _switch_off(self, was_lacking: set[str]) -> Remarks:
        """Switch off slots that now lack a requirement, one after the other."""
        remarks = []
        while begun := self._all_lacking() - was_lacking:
            slot = begun.pop()
            what = SLOTS[self._lacking(slot)[0]].title
            if slot == "control":
                self._owners.put(slot, SIGNALS[OFF](self._runner.model.dt))
                remarks.append(f"The robot stands still because its controller needs {what}")
            else:
                self._owners.put(slot, False)
                remarks.append(_sentence(f"{SLOTS[slot].title} is off, too: it needs {what}"))
        return remarks

    def _all_lacking(self) -> set[str]:
        return {slot for slot in STAGES if self._lacking(slot)}

    def _lacking(self, slot: str) -> list[str]:
        """Return a slot for each unfilled need of a slot."""
        if not self._runner._is_on(slot):
            return []
        return [
            needed[0]
            for needed in self._needs(slot)
            if needed and not any(map(self._runner._is_on, needed))
        ]

    def _needs(self, slot: str) -> list[tuple[str, ...]]:
        """Return the needs of a slot; each need lists its alternative slots."""
        needs = [needed_slots(self._runner._callbacks[slot])]
        if slot == "estimate_state" and self._owners.is_made(slot):
            needs.append(("measure",))
        if slot == "estimate_parameters":
            if source := _SOURCES.get(self._runner.identify_from):
                needs.append((source,))
            if isinstance(self._runner, Experiment):
                needs.append(("control",))
        return needs

    def _problem(self) -> str | None:
        """Return why the run could not continue; None = it could."""
        try:
            self._runner._check_slots()  # not the world: no slot can repair it
        except ValueError as error:
            return str(error)
        return None


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:]


class Stage(Choice):
    """A stage: ``"off"``, ``"default"`` or ``"mine"``."""

    card = "stages"

    def __init__(self, name: str, slot: str, stages: Stages, owners: Owners) -> None:
        self.name = name
        self._slot = slot
        self._stages = stages
        self._owners = owners

    @property
    def value(self) -> str:
        return self._owners.of(self._slot)

    def choices(self) -> Mapping[str, str | None]:
        default = why_no_default() if self._slot == "estimate_state" else None
        return {"off": None, "default": default, "mine": self._owners.why_not_mine(self._slot)}

    def choose(self, name: str) -> Remarks:
        return self._stages.choose(self._slot, name)
