"""The task to identify: its score is what the parameters predict, and nothing else."""

import numpy as np
import pytest

from robsim.teach import Identify


def run_with(one, theta_of_step):
    return one.simulation(
        seed=1,
        init_parameter_estimator=lambda model: object(),
        estimate_parameters=lambda step: theta_of_step(step.k),
    ).run(one.steps)


def test_each_run_has_a_robot_of_its_own():
    one = Identify(steps=30)
    thetas = [one.simulation(seed=seed).run(3).info.theta_true for seed in range(3)]
    assert not np.allclose(thetas[0], thetas[1], rtol=0.01)
    assert np.allclose(np.median(thetas, axis=0), one.values["THETA"], atol=0.2)


def test_the_true_parameters_have_no_error_and_others_what_they_predict():
    one = Identify(steps=30)
    truth = np.asarray(one.simulation(seed=1).run(3).info.theta_true)
    assert one.score(run_with(one, lambda k: truth)) == pytest.approx(
        {"position": 0, "heading": 0, "early": 0}, abs=1e-9
    )
    # d1 of the heading is not multiplied by anything: an error of it is one of the prediction
    turned = truth + np.array([[0] * 5, [0] * 5, [0, 0, 0, 0, 0.1]])
    numbers = one.score(run_with(one, lambda k: truth if k > 15 else turned))
    assert numbers == pytest.approx({"position": 0, "heading": 0, "early": 0}, abs=1e-9)
    numbers = one.score(run_with(one, lambda k: turned))
    assert numbers["heading"] == pytest.approx(np.rad2deg(0.1))
    # those of x and y are multiplied by cos and sin: together by 1
    shifted = truth + np.array([[0, 0, 0, 0, 0.1], [0, 0, 0, 0, 0.1], [0] * 5])
    numbers = one.score(run_with(one, lambda k: truth if k > 15 else shifted))
    assert numbers["position"] == pytest.approx(0, abs=1e-9)
    assert numbers["early"] == pytest.approx(0.1)


def test_without_parameters_there_is_no_score():
    one = Identify(steps=30)
    assert np.isnan(list(one.score(one.simulation(seed=1).run(30)).values())).all()
