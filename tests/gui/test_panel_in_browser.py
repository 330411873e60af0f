"""The panel in a real browser."""

import threading

import pytest

import robsim
from robsim.gui._panel import view as _panel_view
from waiting import wait_for

pytestmark = pytest.mark.slow


def test_start_runs_and_a_closed_page_pauses(open_panel, monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 0.1)
    simulation = robsim.Simulation(measure=True, seed=1)
    view, tab = open_panel(simulation, speed=20)
    tab.click("button[name=start]")
    wait_for(lambda: simulation.n_steps > 20)
    tab.close()
    wait_for(lambda: view.driver.state == "paused")
    assert "robsim driver" in {thread.name for thread in threading.enumerate()}
    view.close()
    assert "robsim driver" not in {thread.name for thread in threading.enumerate()}


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
