"""What matplotlib takes for the same: the alternative in a notebook."""

from __future__ import annotations

import io
import statistics
import time

from matplotlib.figure import Figure

from robsim._core import DriveAround
from robsim.plotting import plot_frame, plot_traces
from robsim.simulation import Simulation

_STEPS = 600
_ROUNDS = 5
_DPI = 100


def measure_matplotlib() -> float:
    """Return the median time to draw a camera view of 600 x 600 and the traces as PNG (ms)."""
    simulation = Simulation(control=DriveAround(), measure=True, seed=1)
    trace = simulation.run(_STEPS)
    times = []
    for _ in range(_ROUNDS + 1):
        started = time.perf_counter()
        camera = Figure(figsize=(6, 6), dpi=_DPI)
        plot_frame(simulation.frame, ax=camera.subplots())
        for figure in (camera, plot_traces(trace)):
            figure.savefig(io.BytesIO(), format="png", dpi=_DPI)
        times.append(1000 * (time.perf_counter() - started))
    return statistics.median(times[1:])
