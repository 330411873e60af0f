"""The page in a real browser: a line that breaks, a page that is loaded anew, the end of Python."""

import pytest

import robsim
from browsers import Page, PanelView
from waiting import wait_for

pytestmark = pytest.mark.slow

MAIN = "main[data-state='{}']"


@pytest.fixture
def served(chromium):
    """A page of our own, so that it can be closed; what the browser complains of is not asked."""
    view = PanelView(robsim.Simulation(area=(300, 300), measure=True, seed=1))
    page = Page(view)
    context = chromium.new_context()
    context.set_default_timeout(300_000)  # ms
    yield view, page, context
    context.close()
    page.close()
    view.close(300)


def shown(context, page, state="paused"):
    tab = context.new_page()
    tab.goto(page.url)
    tab.wait_for_selector(MAIN.format(state))
    return tab


def test_a_broken_line_is_mended_and_one_that_stays_broken_pauses_the_run(served, patience):
    patience(1000.0)  # s: the run goes on till it is back
    view, page, context = served
    tab = shown(context, page)
    tab.click("button[name=start]")
    tab.wait_for_selector(MAIN.format("running"))
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    wait_for(lambda: page.pages and socket not in page.pages)
    tab.wait_for_selector(MAIN.format("running"))
    assert view.driver.state == "running"
    patience(0.0)
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    tab.wait_for_selector(MAIN.format("paused"))
    assert view.driver.state == "paused"
    wait_for(lambda: len(view.links) == 1)


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


def test_what_a_callback_says_is_text(open_panel):
    code = '</script><img src=x onerror="document.title=1"><script>document.title=1</script>'

    def control(step):
        raise ValueError(code + "\u202e\x1b[31m" + "x" * 10**6)

    control.__name__ = code
    _, tab = open_panel(robsim.Simulation(seed=1, control=control))
    tab.locator("button[name='step']").first.click()
    tab.wait_for_selector("main[data-state='failed']")
    error = tab.locator(".robsim-error-text")
    error.wait_for()
    assert code in error.text_content()
    tab.locator("button[name='to_callbacks']").click()
    row = tab.locator(".robsim-slot", has_text=code[:20]).first
    row.wait_for()
    assert tab.title() != "1"
    assert tab.locator("main img, main script").count() == 0
