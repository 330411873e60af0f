"""The disturbances of a simulated world: camera noise, dropout, process noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np

from robsim.gui.panels.settings.setting import Choice, Range, Remarks, Setting
from robsim.simulation import Dropout, PoseNoise, Simulation, WheelNoise
from robsim.vision.imaging.noise import GaussianNoise, UniformNoise

NOISES: Mapping[str, type[UniformNoise | GaussianNoise]] = {
    "uniform": UniformNoise,
    "gaussian": GaussianNoise,
}
_NOISE_LEVEL = 20.0  # %, until one is set

_HEADING = 0.05  # rad of disturbance with each px, as in robsim.estimation.reference


@dataclasses.dataclass(frozen=True)
class Disturbance:
    """A kind of disturbance, by its level."""

    make: Callable[[float], PoseNoise | WheelNoise]
    level: float  # until one is set
    high: float
    step: float
    unit: str


DISTURBANCES = {
    "pose": Disturbance(
        lambda level: PoseNoise.from_sigma(level, level, _HEADING * level), 0.2, 1.0, 0.02, "px"
    ),
    "wheels": Disturbance(WheelNoise, 0.1, 0.5, 0.01, "V"),
}


def world_settings(simulation: Simulation) -> list[Setting]:
    """Return the controls of a world."""
    noise, disturbance = NoiseKind(simulation), DisturbanceKind(simulation)
    return [
        noise,
        NoiseLevel(noise),
        DropoutProbability(simulation),
        disturbance,
        DisturbanceLevel(disturbance),
    ]


class NoiseKind(Choice):
    """The kind of camera noise."""

    name = "noise"

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._last = "gaussian", _NOISE_LEVEL
        self._note()

    @property
    def value(self) -> str:
        noise = self._simulation.noise
        return next((name for name, kind in NOISES.items() if isinstance(noise, kind)), "none")

    @property
    def level(self) -> float:
        """Of the noise, or of the last one (%)."""
        noise = self._simulation.noise
        return self._last[1] if noise is None else float(noise.percent)

    def choices(self) -> Mapping[str, str | None]:
        return dict.fromkeys(("none", *NOISES))

    def choose(self, name: str) -> Remarks:
        self._note()
        self._simulation.noise = None if name == "none" else NOISES[name](self._last[1])
        return []

    def move(self, level: float) -> Remarks:
        """Set the level; without noise there is that of the last kind then."""
        self._note()
        self._simulation.noise = NOISES[self._last[0]](level)
        return []

    def _note(self) -> None:
        if self._simulation.noise is not None:
            self._last = self.value, self.level


class NoiseLevel(Range):
    """The level of the camera noise."""

    name, low, high, step, unit = "noise_level", 0.0, 100.0, 1.0, "%"

    def __init__(self, kind: NoiseKind) -> None:
        self._kind = kind

    @property
    def value(self) -> float:
        return self._kind.level

    def move(self, value: float) -> Remarks:
        return self._kind.move(value)


class DropoutProbability(Range):
    """How probable it is that the robot is hidden."""

    name, low, high, step, unit = "dropout", 0.0, 1.0, 0.01, ""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    @property
    def value(self) -> float:
        dropout = self._simulation.dropout
        return 0.0 if dropout is None else float(dropout.probability)

    def move(self, value: float) -> Remarks:
        dropout = self._simulation.dropout or Dropout(0.0)
        self._simulation.dropout = dataclasses.replace(dropout, probability=value)
        return []


class DisturbanceKind(Choice):
    """What disturbs the motion of the robot."""

    name = "disturbance"

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._levels = {name: form.level for name, form in DISTURBANCES.items()}
        self._last = next(iter(DISTURBANCES))
        self._note()

    @property
    def value(self) -> str:
        noise = self._simulation.process_noise
        if noise is None:
            return "none"
        return "pose" if isinstance(noise, PoseNoise) else "wheels"

    @property
    def form(self) -> Disturbance:
        """That of the disturbance, or of the last one."""
        return DISTURBANCES[self._last if self.value == "none" else self.value]

    @property
    def level(self) -> float:
        """Of the disturbance, or of the last one (px or V)."""
        noise = self._simulation.process_noise
        return (
            self._levels[self._last]
            if noise is None
            else float(np.max(np.asarray(noise.sigma)[:2]))
        )

    def choices(self) -> Mapping[str, str | None]:
        return dict.fromkeys(("none", *DISTURBANCES))

    def choose(self, name: str) -> Remarks:
        self._note()
        if name == "none":
            self._simulation.process_noise = None
            return []
        self._simulation.process_noise = DISTURBANCES[name].make(self._levels[name])
        self._note()
        return []

    def move(self, level: float) -> Remarks:
        """Set the level; without a disturbance there is one of the last kind then."""
        self._simulation.process_noise = self.form.make(level)
        self._note()
        return []

    def _note(self) -> None:
        if self._simulation.process_noise is not None:
            self._last = self.value
            self._levels[self._last] = self.level


class DisturbanceLevel(Range):
    """The level of the disturbance; its unit and limits depend on the kind."""

    name = "disturbance_level"
    low = 0.0

    def __init__(self, kind: DisturbanceKind) -> None:
        self._kind = kind

    @property
    def value(self) -> float:
        return self._kind.level

    @property
    def high(self) -> float:  # type: ignore[override]
        return self._kind.form.high

    @property
    def step(self) -> float:  # type: ignore[override]
        return self._kind.form.step

    @property
    def unit(self) -> str:  # type: ignore[override]
        return self._kind.form.unit

    def move(self, value: float) -> Remarks:
        return self._kind.move(value)
