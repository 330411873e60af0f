"""The figures of the manual of 2008, reproduced with the mouse: what they show, with numbers."""

import re

import pytest

import robsim
from panel_mouse import Mouse, number
from robsim.trace import PARAMETER_NAMES
from waiting import wait_for

pytestmark = pytest.mark.slow

#: As the manual prints them.
TRUE_VALUES = {
    **{"a1X": 1.9375, "a2X": -0.9375, "b1X": 0.20833, "b2X": 0.20833, "d1X": 8.3333e-6},
    **{"a1Y": 1.9375, "a2Y": -0.9375, "b1Y": 0.20833, "b2Y": 0.20833, "d1Y": 8.3333e-6},
    **{"a1P": 1.8333, "a2P": -0.83333, "b1P": 0.030556, "b2P": -0.030556, "d1P": 0},
}


@pytest.fixture
def mouse(open_panel):
    """The panel of a simulation as it is by default: the robot spins, and nothing is on."""
    return Mouse(*open_panel(robsim.Simulation(robot="lab", seed=1), speed=100.0))


def parameters_shown(mouse):
    """Return what is read off at the newest step in each of the 15 charts, and what is weak."""
    charts = {name: mouse.chart(name) for name in PARAMETER_NAMES}
    for name in ("a1X", "b2Y", "d1P"):
        assert charts[name].count("true") > 8  # the crosses
        assert charts[name].count("estimated") > 20
    return {name: number(chart.read(0.995)[1]["estimate"]) for name, chart in charts.items()}


def not_excited(verdict):
    """Return how many parameters are said not to be excited."""
    found = re.search(r"(\d+) not excited", verdict.inner_text())
    return int(found[1]) if found else 0


def test_2_3_and_2_4_the_online_estimate_needs_a_robot_that_drives(mouse):
    mouse.choose("Parameter estimation", "Default")
    mouse.open("Parameters")
    mouse.run(100)
    verdict = mouse.tab.locator(".robsim-verdict")
    wait_for(lambda: not_excited(verdict) >= 9)  # all of x and y but the decay
    spinning = parameters_shown(mouse)
    far = [name for name, true in TRUE_VALUES.items() if abs(spinning[name] - true) > 0.01]
    assert len(far) >= 8
    mouse.tab.get_by_label("Robot drives").select_option("drive-around")
    mouse.run(300)
    wait_for(lambda: not_excited(verdict) == 0)
    for name, value in parameters_shown(mouse).items():
        assert value == pytest.approx(TRUE_VALUES[name], abs=2e-3), name
