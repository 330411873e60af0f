"""The page in a real browser: a line that breaks, a page that is loaded anew, the end of Python."""

import pytest

import robsim
from robsim.gui._hosts.page import Page
from robsim.gui._panel import view as _panel_view
from robsim.gui._panel.view import PanelView
from waiting import wait_for

pytestmark = pytest.mark.slow

MAIN = "main[data-state='{}']"


@pytest.fixture
def served(chromium):
    """A page of our own, so that it can be closed; what the browser complains of is not asked."""
    view = PanelView(robsim.Simulation(area=(300, 300), measure=True, seed=1))
    page = Page(view)
    context = chromium.new_context()
    yield view, page, context
    context.close()
    page.close()
    view.close()


def shown(context, page, state="paused"):
    tab = context.new_page()
    tab.goto(page.url)
    tab.wait_for_selector(MAIN.format(state))
    return tab


def test_a_broken_line_is_mended(served, monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 1000.0)  # s: the run goes on till it is back
    view, page, context = served
    tab = shown(context, page)
    tab.click("button[name=start]")
    tab.wait_for_selector(MAIN.format("running"))
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    wait_for(lambda: page.pages and socket not in page.pages)
    tab.wait_for_selector(MAIN.format("running"))
    tab.click("button[name=pause]")
    tab.wait_for_selector(MAIN.format("paused"))
    assert len(view.links) == 1


def test_a_line_that_is_broken_for_long_pauses_the_run(served, monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 0.0)
    view, page, context = served
    tab = shown(context, page)
    tab.click("button[name=start]")
    tab.wait_for_selector(MAIN.format("running"))
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    tab.wait_for_selector(MAIN.format("paused"))
    assert view.driver.state == "paused"


def test_a_page_that_is_loaded_anew_shows_the_run_as_it_is(served):
    view, page, context = served
    tab = shown(context, page)
    tab.click("button[name=step]")
    wait_for(lambda: view.record.n_steps == 1)
    tab.reload()
    tab.wait_for_selector(MAIN.format("paused"))
    tab.click("button[name=step]")
    wait_for(lambda: view.record.n_steps == 2)
    wait_for(lambda: len(view.links) == 1)


def test_two_pages_show_one_run(served):
    _, page, context = served
    one, two = shown(context, page), shown(context, page)
    one.click("button[name=start]")
    two.wait_for_selector(MAIN.format("running"))
    two.click("button[name=pause]")
    one.wait_for_selector(MAIN.format("paused"))


def test_a_page_tells_that_python_has_gone(served):
    _, page, context = served
    tab = context.new_page()
    tab.clock.install()  # its pauses take no time
    tab.goto(page.url)
    tab.wait_for_selector(MAIN.format("paused"))
    page.close()
    tab.wait_for_selector(MAIN.format("lost"))
    while tab.locator(MAIN.format("lost")).count():  # each try takes a while
        tab.clock.run_for(10_000)
        tab.wait_for_timeout(50)
    tab.wait_for_selector(MAIN.format("gone"))


def test_a_panel_that_was_closed_is_not_looked_for(served):
    view, page, context = served
    tab = shown(context, page)
    view.close()
    tab.wait_for_selector(MAIN.format("closed"))
    tab.evaluate("window.tries = 0; WebSocket = class { constructor() { window.tries += 1; } }; 0")
    page.close()
    tab.wait_for_timeout(1000)  # the first try would come after 0.3 s
    assert tab.evaluate("window.tries") == 0
    assert tab.locator(MAIN.format("closed")).count() == 1
