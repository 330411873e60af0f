"""The panel in a page, measured."""

from __future__ import annotations

import shutil
import time
from typing import Any

from robsim.gui._bench.barcode import SAMPLER
from robsim.gui._bench.figures import Painted, painted
from robsim.gui._bench.scene import SIZE, measured_view
from robsim.gui._page import Page

_WARM_UP = 2.0  # s
_ARGUMENTS = ["--no-sandbox", "--disable-background-networking", "--no-first-run"]


def chromium_path() -> str:
    """Return where Chromium is."""
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if (path := shutil.which(name)) is not None:
            return path
    raise FileNotFoundError("no Chromium found: install the package chromium")


def measure_page(seconds: float) -> Painted:
    """Return what a page in Chromium paints."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=_ARGUMENTS)
        try:
            return measure_in(browser, seconds)
        finally:
            browser.close()


def measure_in(browser: Any, seconds: float) -> Painted:
    """Return what a page in a browser paints, which is a `Browser` of Playwright."""
    view, done = measured_view()
    page = Page(view)
    try:
        tab = browser.new_page(viewport={"width": 2 * SIZE + 240, "height": SIZE + 300})
        tab.goto(page.url)
        tab.locator(".robsim-transport button[name=start]").click()
        time.sleep(_WARM_UP)
        tab.evaluate(*SAMPLER)
        busy, began = time.process_time(), time.monotonic()
        time.sleep(seconds)
        busy, span = time.process_time() - busy, time.monotonic() - began
        seen = [tuple(pair) for pair in tab.evaluate("robsimSeen")]
        tab.close()
    finally:
        page.close()
        view.close()
    return painted("page", seen[1:], done, span, busy)
