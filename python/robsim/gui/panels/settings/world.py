"""The disturbances of a simulated world: camera noise, dropout, process noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from robsim.base.values import Level
from robsim.gui.panels.settings.setting import Choice, Range, Remarks, Setting
from robsim.simulation import Simulation
from robsim.simulation.option import Option
from robsim.simulation.options import OPTIONS


def world_settings(simulation: Simulation) -> list[Setting]:
    noise = DisturbanceKind(simulation, "noise", "noise", "gaussian")
    disturbance = DisturbanceKind(simulation, "disturbance", "process_noise", "pose")
    return [
        noise,
        DisturbanceLevel(noise),
        disturbance,
        DisturbanceLevel(disturbance),
        *(OptionSlider(simulation, option) for option in OPTIONS.values() if option.label),
    ]


class DisturbanceKind(Choice):
    """The kind of the camera noise or of the process noise, from the option's row."""

    card = "world"

    def __init__(self, simulation: Simulation, name: str, option: str, usual: str) -> None:
        self.name, self.tip = name, OPTIONS[option].doc
        self._simulation, self._option = simulation, option
        kinds: tuple[Any, ...] = OPTIONS[option].types
        self._kinds = {kind._kind: kind for kind in kinds}
        self._last = usual
        self._levels = {kind._LEVEL: kind._LEVEL.default for kind in kinds}
        self._note()

    @property
    def _noise(self) -> Any:
        return getattr(self._simulation, self._option)

    @property
    def value(self) -> str:
        return "none" if self._noise is None else str(self._noise._kind)

    @property
    def range(self) -> Level:
        """The range of levels of the current or last disturbance."""
        level: Level = self._kinds[self._last if self._noise is None else self.value]._LEVEL
        return level

    @property
    def level(self) -> float:
        """The level of the current or last disturbance."""
        return float(self._levels[self.range] if self._noise is None else self._noise._level)

    def choices(self) -> Mapping[str, str | None]:
        return dict.fromkeys(("none", *self._kinds))

    def choose(self, name: str) -> Remarks:
        self._note()
        kind = self._kinds.get(name)
        return self._set(None if kind is None else made(kind, self._levels[kind._LEVEL]))

    def move(self, level: float) -> Remarks:
        """Set the level; if the disturbance is off, switch on the last kind."""
        self._note()
        return self._set(made(self._kinds[self._last], level))

    def _set(self, noise: Any) -> Remarks:
        setattr(self._simulation, self._option, noise)
        self._note()
        return []

    def _note(self) -> None:
        if self._noise is not None:
            self._last = self.value
            self._levels[self.range] = self.level


def made(kind: Any, level: float) -> Any:
    """Return a disturbance with a level: most kinds have no other argument."""
    return getattr(kind, "_of_level", kind)(level)


class DisturbanceLevel(Range):
    """The level of a disturbance; its unit and limits depend on the kind."""

    card = "world"

    def __init__(self, kind: DisturbanceKind) -> None:
        self.name = f"{kind.name}_level"
        self._kind = kind

    @property
    def value(self) -> float:
        return self._kind.level

    @property
    def range(self) -> Level:  # type: ignore[override]
        return self._kind.range

    def move(self, value: float) -> Remarks:
        return self._kind.move(value)


class OptionSlider(Range):
    """A numeric option, or an option with a number; the option's row has name and limits."""

    card = "world"

    def __init__(self, simulation: Simulation, option: Option) -> None:
        self.name, self.tip, self.label = option.name, option.doc, option.label
        self.range = option.level or Level("", 1, 1, 0)
        self._simulation, self._option = simulation, option

    @property
    def value(self) -> float:
        value = getattr(self._simulation, self.name)
        if self._option.part:
            value = 0 if value is None else getattr(value, self._option.part)
        return float(value)

    def move(self, value: float) -> Remarks:
        new: Any = value
        if self._option.part:
            old = getattr(self._simulation, self.name) or self._option.types[0](value)
            new = dataclasses.replace(old, **{self._option.part: value})
        setattr(self._simulation, self.name, new)
        return []
