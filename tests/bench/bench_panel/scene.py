"""The run that is shown while the panel is measured."""

from __future__ import annotations

import time

from bench_panel.barcode import stamped_picture
from robsim._core import DriveAround, Step
from robsim.gui.panels.settings.estimator import default_estimator
from robsim.gui.panels.view import PanelView
from robsim.simulation import Simulation

_SPEED = 6.0  # times dt = 0.2 s: 30 steps/s

#: Step -> when it was done (ms), and the processor time of the process by then (s).
Steps = dict[int, tuple[float, float]]


def measured_view() -> tuple[PanelView, Steps]:
    """Return a panel with all stages on and numbered pictures, and the times of its steps."""
    simulation = Simulation(control=DriveAround(), measure=True, estimate_parameters=True, seed=1)
    simulation.estimate_state = default_estimator(simulation)
    view = PanelView(simulation, speed=_SPEED)
    steps: Steps = {}

    def note(step: Step) -> None:
        steps[step.k] = 1000 * time.time(), time.process_time()

    view.driver.on_step.insert(0, note)
    view.camera.encode = stamped_picture  # type: ignore[method-assign]
    return view, steps
