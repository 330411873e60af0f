"""A tab of Chromium in which a panel is measured."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

from bench_panel.figures import Watched
from bench_panel.scene import SAMPLER

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

SIZE = 600  # px of the picture on the screen
_WARM_UP = 2.0  # s
_ARGUMENTS = ["--no-sandbox", "--disable-background-networking", "--no-first-run"]
_CHOICES = {"overlays": {"truth": True}, "objects": True, "tab": "traces"}
_WIDEN = """(panel, width) => panel.style.setProperty("--robsim-left", `${width}px`)"""
_SIDES = "canvas => [canvas.width, canvas.height]"


def chromium_path() -> str:
    """Return where Chromium is."""
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if (path := shutil.which(name)) is not None:
            return path
    raise FileNotFoundError("no Chromium found: install the package chromium")


@contextmanager
def open_chromium() -> Iterator[Browser]:
    """Start a Chromium; ImportError and FileNotFoundError say what to install."""
    if find_spec("playwright") is None:
        raise ImportError("the panel is measured with Playwright: pip install playwright")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=_ARGUMENTS)
        yield browser
        browser.close()


@contextmanager
def new_context(browser: Browser) -> Iterator[BrowserContext]:
    """Open a context in which panels have everything on, in a window that has room for it."""
    context = browser.new_context(viewport={"width": 1800, "height": 1300})
    choices = json.dumps(json.dumps(_CHOICES))
    context.add_init_script(f"localStorage.setItem('robsim', {choices})")
    yield context
    context.close()


def watch(tab: Page, seconds: float) -> Watched:
    """Start the run of the panel that a tab shows, and return what is painted of it."""
    panel = tab.locator(".robsim-panel")
    panel.evaluate(_WIDEN, SIZE + 2)  # with its border
    start = panel.locator(".robsim-transport button[name=start]")
    start.and_(tab.locator(":enabled")).wait_for(timeout=300_000)  # all tabs are there then
    for sheet in panel.get_by_role("tab").all():
        sheet.click()  # its columns come from now on
    panel.get_by_role("tab").first.click()
    start.click()
    time.sleep(_WARM_UP)
    sides = panel.locator(".robsim-camera canvas").evaluate(_SIDES)
    if sides != [SIZE, SIZE]:
        raise RuntimeError(f"the picture is to be {SIZE} px wide and high, but has {sides}")
    tab.evaluate(*SAMPLER)
    time.sleep(seconds)
    began, ended, seen = tab.evaluate("[robsimBegan, Date.now(), robsimSeen]")
    return Watched(seen=[(k, at) for k, at in seen[1:]], began=began, ended=ended)
