"""The task to follow a path: its scores and its rule."""

import numpy as np
import pytest

import robsim
from robsim.teach import Follow


def driven_along(positions, control=lambda step: (0.0, 0.0)):
    """A run that is at these positions."""
    one = Follow(waypoints=[(200, 200), (300, 200)], steps=len(positions), dropout=0, noise=0)
    poses = [(*position, 0.0) for position in positions]
    scenario = one.scenario.replace(start=poses[0], process_noise=None, measure=False)
    sim = robsim.Simulation(scenario, evaluate_model=lambda world: poses[world.k], control=control)
    return one, sim.run(one.steps)


def test_error_and_time_are_those_of_a_path_that_is_completed():
    one, trace = driven_along([(150, 200), (200, 210), (250, 200), (300, 200)])
    numbers = one.score(trace)
    assert numbers["left"] == 0
    assert numbers["time"] == pytest.approx(0.6)
    assert numbers["error"] == pytest.approx(np.sqrt(10**2 / 4))


def test_who_stands_still_has_no_error_that_counts():
    one, trace = driven_along([(150, 200), (150, 200), (150, 200)])
    numbers = one.score(trace)
    assert np.isnan([numbers["error"], numbers["time"]]).all()
    assert numbers["left"] == 100


def test_half_a_path_has_half_of_the_waypoints():
    one, trace = driven_along([(150, 200), (200, 200), (200, 200)])
    assert one.score(trace)["left"] == pytest.approx(50)


def test_with_too_much_voltage_there_are_no_numbers():
    one, trace = driven_along([(150, 200), (200, 200), (300, 200)], control=lambda step: (2, 0))
    assert one.broken_rule(trace) == "2 V at step 0: a motor must not get more than 1 V"
    assert np.isnan(list(one.score(trace).values())).all()
