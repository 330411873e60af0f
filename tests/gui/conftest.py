"""Panels for the tests, in a browser too."""

import sys
import threading
import traceback
from contextlib import suppress

import pytest

from browsers import Page, PanelView, Watcher
from chromium_browser import new_tab, running_chromium
from commands import command
from fake_host import FakeHost
from waiting import wait_for

#: What is on a canvas before a picture: nothing, then the ground of either theme.
BARE = ("0,0,0,0", "128,128,128,255", "232,234,238,255", "10,12,15,255")


class Clock:
    """Stands still until it is moved on."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def time(self):
        return self.now

    def advance(self, worker, seconds):
        """Move it on, and let a worker look what is due now."""
        self.now += seconds
        for _ in range(20):
            settled = threading.Event()
            worker.post(settled.set)
            assert settled.wait(300)


@pytest.fixture
def clock(monkeypatch):
    """The clock of drivers and views: no time passes for them by itself."""
    clock = Clock()
    panel = ("view", "still_part", "record", "run.camera", "run.transport")
    panel += ("analysis.past",)
    monkeypatch.setattr("robsim.simulation.time_limit.time", clock)
    for module in ("_driver", "_worker", "_view", "_link", *(f"panels.{name}" for name in panel)):
        monkeypatch.setattr(f"robsim.gui.{module}.time", clock)
    return clock


@pytest.fixture
def patience(monkeypatch):
    """Return a function that sets how long a panel waits for a page to come back (s)."""
    return lambda seconds: monkeypatch.setattr("robsim.gui.panels.view._PATIENCE", seconds)


@pytest.fixture
def mistakes(monkeypatch):
    """What Python is told of that nobody waits for."""
    told = []
    monkeypatch.setattr(threading, "excepthook", lambda about: told.append(about.exc_value))
    return told


@pytest.fixture
def folder(tmp_path):
    """A folder with the default callbacks."""
    assert command("new", "mine", cwd=tmp_path).exit_code == 0
    return tmp_path / "mine"


@pytest.fixture
def watch():
    """Return a function that opens a panel of a runner, with one who watches."""
    views = []

    def open_it(runner, **options):
        views.append(PanelView(runner, **options))
        watcher = Watcher(views[-1])
        watcher.settle()
        return watcher

    yield open_it
    for view in views:
        view.close()


@pytest.fixture(scope="module")
def chromium():
    """A running browser; tests without one are skipped.

    Of each module its own: while it runs, Playwright has an asyncio loop in the thread of the
    tests, where tests of other modules want to run theirs.
    """
    yield from running_chromium()


def said_by(tab):
    """Return the words of a page, and the names of its disabled controls."""
    disabled = tab.evaluate("[...document.querySelectorAll(':disabled')].map((e) => e.name)")
    return f"{tab.locator('body').inner_text(timeout=10_000)}\ndisabled: {disabled}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Add to a failure in a browser what each page says, and where the threads of robsim are."""
    report = yield
    browser = item.funcargs.get("chromium")
    if report.failed and call.when == "call" and browser is not None:
        with suppress(Exception):  # of a page that is gone: the failure is to be seen
            report.sections += [
                ("page", said_by(tab)) for one in browser.contexts for tab in one.pages
            ]
        frames = sys._current_frames()
        for thread in threading.enumerate():
            if thread.name.startswith("robsim") and thread.ident in frames:
                stack = traceback.format_stack(frames[thread.ident], 8)
                report.sections.append((thread.name, "".join(stack)))
    return report


@pytest.fixture
def open_view(chromium):
    """Return a function that shows a view in a page of the browser, and closes both at the end."""
    open_now = []

    def open_it(view, **options):
        page = Page(view)
        tab, complaints = new_tab(chromium, **options)
        open_now.append((view, page, tab, complaints))
        tab.goto(page.url)
        tab.wait_for_selector("main[data-state]")
        return tab

    yield open_it
    for view, page, tab, complaints in open_now:
        tab.context.close()
        page.close()
        view.close()
        assert complaints == []


@pytest.fixture
def open_panel(open_view):
    """Return a function that shows a runner in a page: the view and the page of the browser."""

    def open_it(runner, *, speed=5.0, **options):
        view = PanelView(runner, speed=speed)
        return view, open_view(view, **options)

    return open_it


@pytest.fixture
def open_tool(open_view):
    """Return a function that shows a tool in a page of the browser, with its picture."""
    middle = (
        "(() => { const c = document.querySelector('.robsim-camera canvas');"
        " return c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data.join(); })()"
    )

    def open_it(tool, **options):
        tab = open_view(tool._view, **options)
        wait_for(lambda: tab.evaluate(middle) not in BARE)
        return tab

    return open_it


@pytest.fixture
def open_fake(chromium):
    """Return a function that shows the module in a tab, with a `FakeHost` in Python's place."""
    hosts = []

    def open_it(**options):
        hosts.append(FakeHost(chromium, **options))
        return hosts[-1]

    yield open_it
    for host in hosts:
        host.close()
