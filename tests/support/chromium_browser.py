"""Debian's Chromium, driven by Playwright: its tabs, and files dragged into them."""

import shutil

import pytest

ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
]


def running_chromium():
    """Yield a running browser and end it, for a fixture; tests without one are skipped."""
    playwright = pytest.importorskip("playwright.sync_api")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("needs chromium")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=ARGUMENTS, timeout=300_000)
        yield browser
        browser.close()


def new_tab(browser, *, size=(1440, 900), theme="light", **options):
    """Open a tab in a context of its own; return it, and the list of what it complains of."""
    viewport = dict(zip(("width", "height"), size, strict=True))
    context = browser.new_context(viewport=viewport, color_scheme=theme, **options)
    context.set_default_timeout(300_000)  # ms
    tab, complaints = context.new_page(), []
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda m: m.type == "error" and complaints.append(m.text))
    return tab, complaints


def drag_file(tab, file, look=None, *, at=(300, 300), drops=True):
    """Drag a file to a place of a tab, and drop it, or leave; `look` is called in between."""
    session = tab.context.new_cdp_session(tab)
    about = {"items": [], "files": [str(file)], "dragOperationsMask": 1}

    def do(kind, x, y):
        session.send("Input.dispatchDragEvent", {"type": kind, "x": x, "y": y, "data": about})

    do("dragEnter", *at)
    do("dragOver", *at)
    if look:
        look()
    if drops:
        do("drop", *at)
    else:
        do("dragOver", -5, -5)
    session.detach()
