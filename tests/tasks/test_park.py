"""The task to park: its scores and its rule."""

import numpy as np
import pytest

import robsim
from robsim.teach import ParkTask


def run_at(goal_offset, control=lambda step: (0.0, 0.0)):
    """A run that stands still at a place beside the goal."""
    one = ParkTask(goal=(400, 300, 1), steps=10, noise=0, dropout=0, mismatch=0)
    scenario = one.scenario.replace(
        start=np.add(one.goal, goal_offset), process_noise=None, measure=False
    )
    sim = robsim.Simulation(scenario, evaluate_model=lambda world: world.pose_1, control=control)
    return one, sim.run(one.steps)


def test_a_robot_that_stands_there_has_settled_at_once():
    one, trace = run_at((3, 4, 0.1))
    numbers = one.score(trace)
    assert numbers["settling"] == 0
    assert numbers["distance"] == pytest.approx(5)
    assert numbers["heading"] == pytest.approx(np.rad2deg(0.1))
    assert numbers["overshoot"] == 0


@pytest.mark.parametrize("offset", [(25, 0, 0), (0, 0, 0.2)])
def test_out_of_a_tolerance_it_has_not(offset):
    one, trace = run_at(offset)
    assert np.isnan(one.score(trace)["settling"])


def test_with_too_much_voltage_there_are_no_numbers():
    one, trace = run_at((0, 0, 0), control=lambda step: (0, -1.5 if step.k == 4 else 1))
    assert one.broken_rule(trace) == "1.5 V at step 4: a motor must not get more than 1 V"
    assert np.isnan(list(one.score(trace).values())).all()
    one, trace = run_at((0, 0, 0), control=lambda step: (1, -1))
    assert one.broken_rule(trace) is None
