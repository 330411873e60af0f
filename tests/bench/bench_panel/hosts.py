"""The panel in a page and in a JupyterLab, measured."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from bench_panel.browser import new_context, watch
from bench_panel.figures import Painted, painted
from bench_panel.lab import Lab, Server, lab_server, write_notebook
from bench_panel.scene import measured_view
from robsim.gui.hosts.page import Page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

_SHOW = f"""import sys
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from bench_panel.scene import measured_view
from robsim.gui.hosts.notebook import NotebookLink
view, steps = measured_view()
NotebookLink(view).display(view.snapshot)"""
_TELL = """import json
print(json.dumps(list(steps.items())))"""


def is_lab_there() -> bool:
    """Return whether there is a JupyterLab that can show a panel."""
    return all(importlib.util.find_spec(name) for name in ("jupyterlab", "anywidget"))


def measure_lab(browser: Browser, seconds: float) -> Painted:
    """Return what a notebook paints."""
    with TemporaryDirectory() as folder, lab_server(Path(folder)) as server:
        return measure_notebook(browser, server, seconds)


def measure_notebook(browser: Browser, server: Server, seconds: float) -> Painted:
    """Return what a new notebook of a server paints."""
    with new_context(browser) as context:
        file = server.folder / "measured.ipynb"
        write_notebook(file, [_SHOW, _TELL])
        lab = Lab(context, server, file)
        lab.run(0)
        watched = watch(lab.page, seconds)
        lab.run(1)
        steps = dict(json.loads(lab.output(1)))
    return painted("JupyterLab", watched, steps)


def measure_page(browser: Browser, seconds: float) -> Painted:
    """Return what a page paints."""
    view, steps = measured_view()
    page = Page(view)
    try:
        with new_context(browser) as context:
            tab = context.new_page()
            tab.goto(page.url)
            watched = watch(tab, seconds)
    finally:
        page.close()
        view.close()
    return painted("page", watched, steps)
