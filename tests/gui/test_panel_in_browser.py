"""The panel in a real browser."""

import threading
import time

import pytest

import robsim

pytestmark = pytest.mark.slow


def wait_for(condition, seconds=10):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.02)


def test_start_runs_and_a_closed_page_pauses(open_panel):
    simulation = robsim.Simulation(measure=True, seed=1)
    view, tab = open_panel(simulation, speed=20)
    tab.click("button[name=start]")
    wait_for(lambda: simulation.n_steps > 20)
    tab.close()
    wait_for(lambda: view.driver.state == "paused")
    assert "robsim driver" in {thread.name for thread in threading.enumerate()}
    view.close()
    assert "robsim driver" not in {thread.name for thread in threading.enumerate()}
