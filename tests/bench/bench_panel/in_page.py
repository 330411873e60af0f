"""The panel in a page, measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bench_panel.browser import new_context, watch
from bench_panel.figures import Painted, painted
from bench_panel.scene import measured_view
from robsim.gui.hosts.page import Page

if TYPE_CHECKING:
    from playwright.sync_api import Browser


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
