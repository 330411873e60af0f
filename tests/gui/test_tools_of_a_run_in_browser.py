"""Define Robot, Train Camera and Resume simulation in the panel of a run, in Chromium."""

import numpy as np
import pytest

import robsim
from robsim.vision import default_robot
from waiting import wait_for

pytestmark = pytest.mark.slow


def simulation():
    return robsim.Simulation(robot="lab", measure=True, area=(400, 400), seed=1, headings=None)


def test_a_robot_from_the_list_drives_on(open_panel, user_folder):
    sim = simulation()
    view, tab = open_panel(sim, theme="dark")
    tab.click("[name=define_robot]")
    tab.wait_for_selector(".robsim-tool")
    assert not tab.is_visible(".robsim-transport")
    tab.select_option(".robsim-tool [name=robot]", "sheep")
    wait_for(lambda: view.tools.tool._view.name == "sheep")
    tab.click("[name=use_tool]")
    tab.wait_for_selector(".robsim-title-name:has-text('sheep')")
    assert tab.is_visible(".robsim-transport")
    wait_for(lambda: sim.n_steps > 2)
    assert default_robot() == "sheep"


def test_keys_in_a_tool_are_the_tools(open_panel, user_folder):
    sim = simulation()
    view, tab = open_panel(sim)
    tab.click("[name=define_robot]")
    tab.wait_for_selector(".robsim-tool [value=outline][aria-checked=true]")
    tab.focus(".robsim-tool canvas")
    tab.keyboard.press("Enter")
    tab.wait_for_selector(".robsim-tool [value=red][aria-checked=true]")
    tab.keyboard.press("Space")
    tab.keyboard.press("ArrowRight")
    tab.mouse.click(1400, 850)  # beside the tool, the run does not hear them either
    for key in (" ", ".", "s"):
        tab.keyboard.press(key)
    tab.click(".robsim-tool [name=clear]")
    tab.wait_for_selector(".robsim-problems:visible")
    tab.click("[name=use_tool]")
    tab.locator(".robsim-toast:has-text('red marker needs 3 corners')").wait_for()
    tab.click("[name=discard_tool]")
    tab.wait_for_selector(".robsim-tool", state="detached")
    assert view.driver.state == "paused"
    assert sim.n_steps == 0


def test_motors_are_stopped_beside_a_tool(open_panel, user_folder):
    sent = []
    frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 2000
    options = {"area": (64, 64), "measure": False, "identify_from": "truth"}
    experiment = robsim.Experiment(
        frames, send=lambda u: sent.append(tuple(u)), control=lambda step: (1, 2), **options
    )
    view, tab = open_panel(experiment, speed=0.2)
    tab.click(".robsim-transport [name=start]")
    tab.click("[name=train_colors]")
    tab.wait_for_selector(".robsim-tool")
    wait_for(lambda: (1, 2) in sent)
    tab.click(".robsim-tool-bar [name=stop]")
    wait_for(lambda: sent[-1:] == [(0, 0)])
    wait_for(lambda: view.driver.is_stopped)
