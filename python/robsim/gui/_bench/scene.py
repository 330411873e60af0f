"""The run that is shown while the panel is measured."""

from __future__ import annotations

import time

from robsim._core import DriveAround, Step
from robsim.gui._bench.barcode import stamped_picture
from robsim.gui._panel.view import PanelView
from robsim.simulation import Simulation

SPEED = 6.0  # times dt = 0.2 s: 30 steps/s
SIZE = 600  # px on the screen


def measured_view() -> tuple[PanelView, dict[int, float]]:
    """Return a panel with numbered pictures, and when each step was done (ms)."""
    simulation = Simulation(control=DriveAround(), measure=True, estimate_parameters=True, seed=1)
    view = PanelView(simulation, speed=SPEED)
    done: dict[int, float] = {}

    def note(step: Step) -> None:
        done[step.k] = 1000 * time.time()

    view.driver.on_step.insert(0, note)
    view.camera.encode = stamped_picture  # type: ignore[method-assign]
    return view, done
