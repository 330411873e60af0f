"""How fast the run goes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from robsim.gui.panels.settings.setting import Range, Remarks

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView


class Speed(Range):
    """The speed, as a multiple of real time; 0 = as fast as it goes."""

    name, low, high, step, unit = "speed", 0.2, 100.0, 0.1, "x"

    def __init__(self, panel: PanelView) -> None:
        self._panel = panel

    @property
    def value(self) -> float:
        speed = self._panel.driver.speed
        return 0.0 if math.isinf(speed) else speed

    def is_within(self, value: float) -> bool:
        return value == 0 or super().is_within(value)

    def move(self, value: float) -> Remarks:
        self._panel.driver.speed = value or math.inf
        return []
