"""`run_panel_bench`: the panel in a browser, measured."""

from __future__ import annotations

import importlib.util

from robsim.gui._bench.figures import PanelBench
from robsim.gui._bench.in_page import measure_page
from robsim.gui._bench.with_matplotlib import measure_matplotlib


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
    if importlib.util.find_spec("playwright") is None:
        raise ImportError("the panel is measured with Playwright: pip install playwright")
    page = measure_page(seconds)
    return PanelBench(hosts=(page,), matplotlib=measure_matplotlib())
