"""`run_panel_bench`: the panel in a browser, measured beside matplotlib."""

from __future__ import annotations

import io
import statistics
import time

from matplotlib.figure import Figure

from bench_panel.browser import open_chromium
from bench_panel.figures import PanelBench
from bench_panel.hosts import is_lab_there, measure_lab, measure_page
from robsim._core import DriveAround
from robsim.plotting import plot_frame, plot_traces
from robsim.simulation import Simulation


def run_panel_bench(*, seconds: float = 8.0) -> PanelBench:
    """Measure what Chromium paints of a panel, beside what matplotlib would take.

    Parameters
    ----------
    seconds : float
        How long to look (s).

    Returns
    -------
    PanelBench
        The rates, latencies and times; print it.

    Raises
    ------
    ImportError, FileNotFoundError
        If Playwright or Chromium is missing; the message says what to install.
    """
    measured = [measure_page, measure_lab] if is_lab_there() else [measure_page]
    with open_chromium() as browser:
        hosts = tuple(measure(browser, seconds) for measure in measured)
    lacks_lab = len(hosts) < 2
    return PanelBench(hosts=hosts, matplotlib=measure_matplotlib(), lacks_lab=lacks_lab)


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
