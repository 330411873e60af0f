"""The control of the speed."""

from __future__ import annotations

import math

from robsim.base.values import Level
from robsim.gui._driver import Driver
from robsim.gui.panels.settings.setting import Range, Remarks


class Speed(Range):
    """The speed, as a multiple of real time; 0 = as fast as it goes."""

    name, card = "speed", "drive"
    range = Level("x", high=100.0, step=0.1, default=1.0, low=0.2)

    def __init__(self, driver: Driver) -> None:
        self._driver = driver

    @property
    def value(self) -> float:
        speed = self._driver.speed
        return 0.0 if math.isinf(speed) else speed

    def is_within(self, value: float) -> bool:
        return value == 0 or super().is_within(value)

    def move(self, value: float) -> Remarks:
        self._driver.speed = value or math.inf
        return []
