"""The owners of the callbacks in the slots: the user or the panel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from robsim.gui.panels.settings.signals import signal_of
from robsim.simulation import Experiment, Simulation
from robsim.simulation.slots import SLOTS

Owner = Literal["off", "default", "mine"]


class Owners:
    """Keeps the user's values of the slots, so that the user can choose them again.

    These are the initial values, later values such as from a cell, and the files of a folder.
    Any thread may read: slots hold plain values.
    """

    def __init__(self, runner: Simulation | Experiment) -> None:
        self._runner = runner
        self._made: dict[str, tuple[object, object]] = {}  # the panel's last two of a slot
        self._users: dict[str, Any] = {}
        self.look()

    def look(self) -> None:
        """Note the user's new values of slots since the last call."""
        for slot in self._runner.SLOTS:
            if self.of(slot) == "mine":
                self._users[slot] = self._runner._callbacks[slot]

    def of(self, slot: str) -> Owner:
        """Return the owner of the callback in a slot."""
        value = self._runner._callbacks[slot]
        if value is None or value is False:
            return "off" if SLOTS[slot].is_optional else "default"
        if value is True or self.is_made(slot) or self._is_default(slot, value):
            return "default"
        return "mine"

    def is_made(self, slot: str) -> bool:
        """Return whether the panel made the value of a slot."""
        value = self._runner._callbacks[slot]
        return value is not None and any(value is made for made in self._made.get(slot, ()))

    def why_not_mine(self, slot: str) -> str | None:
        """Return why a slot has no user's value; None = it has one."""
        files = self._runner._from_folder
        if files.get(slot) is False:
            return f"{slot}.py is switched off: it has ENABLED = False"
        if slot in self._users or callable(files.get(slot)):
            return None
        if self._runner._folder is not None:
            return f"your folder has no {slot}.py"
        run = "exp" if isinstance(self._runner, Experiment) else "sim"
        return f"yours is missing: set {run}.{slot} = ... in a cell, or add {slot}.py to a folder"

    def put(self, slot: str, value: Any) -> None:
        """Fill a slot with a value of the panel; in the thread of the run."""
        # Another thread may look between these lines.
        self._made[slot] = (self._runner._callbacks[slot] if self.is_made(slot) else None, value)
        self._runner._choose(slot, value)

    def put_mine(self, slot: str) -> None:
        """Fill a slot with the user's value; in the thread of the run."""
        if callable(self._runner._from_folder.get(slot)):
            self._runner._choose_file(slot)
        else:
            self._runner._choose(slot, self._users[slot])

    def kept(self, slots: tuple[str, ...]) -> Callable[[], None]:
        """Return a function that restores the slots' current values."""
        runner = self._runner
        before = {slot: (runner._callbacks[slot], runner._given[slot]) for slot in slots}

        def put_back() -> None:
            for slot, (value, given) in before.items():
                if runner._callbacks[slot] is not value:
                    runner._set_slot(slot, value)
                runner._given[slot] = given

        return put_back

    def _is_default(self, slot: str, value: object) -> bool:
        if slot == "control":
            return signal_of(value) is not None
        return slot == "define_model" and value == self._runner._default(slot)


def owners_of(runner: Simulation | Experiment) -> Owners:
    """Return a run's owners; all panels of the run share them."""
    if "_owners" not in vars(runner):
        vars(runner)["_owners"] = Owners(runner)
    owners: Owners = vars(runner)["_owners"]
    return owners
