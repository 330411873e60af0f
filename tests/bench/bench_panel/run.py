"""`run_panel_bench`: the panel in a browser, measured."""

from __future__ import annotations

from bench_panel.browser import open_chromium
from bench_panel.figures import PanelBench
from bench_panel.in_lab import is_lab_there, measure_lab
from bench_panel.in_page import measure_page
from bench_panel.with_matplotlib import measure_matplotlib


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
