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
