"""The task to measure in noise: its scores, its solutions, its sheet."""

import numpy as np
import pytest

import robsim
from robsim.teach import Measure


def test_no_measurement_is_the_worst_there_is():
    one = Measure(steps=12)
    trace = one.simulation(seed=1, measure=lambda step: None).run(one.steps)
    numbers = one.score(trace)
    assert np.isnan(numbers["position"])
    assert np.isnan(numbers["heading"])
    assert numbers["lost"] == 100 * np.mean(~trace.hidden)


def test_errors_and_false_poses_are_scored_by_hand():
    one = Measure(steps=20, dropout=0, noise=0)
    truth = one.simulation(seed=1).run(20).pose_true

    def measure(step):
        x, y, heading = truth[step.k]
        if step.k < 2:
            return robsim.Measurement((x + 50, y, heading))  # false
        return None if step.k == 2 else robsim.Measurement((x + 3, y + 4, heading - 0.1))

    numbers = one.score(one.simulation(seed=1, measure=measure).run(20))
    assert numbers["lost"] == pytest.approx(100 * 3 / 20)
    assert numbers["position"] == pytest.approx(5)
    assert numbers["heading"] == pytest.approx(np.rad2deg(0.1))


def test_a_pose_of_a_hidden_robot_is_not_lost_if_it_is_right():
    one = Measure(steps=12, dropout=1)
    numbers = one.score(one.simulation(seed=1).run(12))
    assert numbers["lost"] == 0
