"""The task to estimate: what is told is true, and scores are what they say."""

import numpy as np
import pytest

import robsim
from robsim.estimation import wrapped_error
from robsim.teach import Estimate, solution_folder


@pytest.mark.long
def test_the_told_noise_of_measurements_is_what_they_have():
    for noise in (0, 20):
        one = Estimate(noise=noise, dropout=0)
        errors = [
            wrapped_error(trace.pose_measured, trace.pose_true)
            for trace in (one.simulation(seed=seed).run(60) for seed in range(8))
        ]
        told = one.values["MEASUREMENT_SIGMA"]
        assert np.std(np.concatenate(errors), axis=0) == pytest.approx(told, rel=0.1)


def test_a_pose_and_a_covariance_are_scored_by_hand():
    one = Estimate(steps=30, dropout=0)
    truth = one.simulation(seed=1).run(30).pose_true

    def estimate_state(step):
        error = (900, 900, 3) if step.k < 10 else (3, 4, 0.1)
        return robsim.Estimate(truth[step.k] + error, np.diag((9.0, 16.0, 0.04)))

    trace = one.simulation(seed=1, estimate_state=estimate_state).run(30)
    assert one.score(trace) == pytest.approx(
        {"position": 5, "heading": np.rad2deg(0.1), "consistency": (1 + 1 + 0.25) / 3}
    )


def test_without_an_estimate_there_is_no_score_and_without_a_covariance_no_consistency():
    one = Estimate(steps=20, dropout=0)
    trace = one.simulation(
        seed=1, estimate_state=lambda step: robsim.Estimate((0, 0, 0), np.zeros((3, 3)))
    ).run(20)
    assert np.isnan(one.score(trace)["consistency"])
    assert np.isnan(list(one.score(one.simulation(seed=1).run(20)).values())).all()


@pytest.mark.long
def test_the_reference_is_consistent_with_the_noises_that_are_told():
    one = Estimate(slip=1.0, turn=0.03, noise=10)
    result = robsim.campaign(
        one.scenario,
        vary={"folder": {"reference": solution_folder(one, one.solutions[0])}},
        metrics={"task": one.score},
        runs=20,
        steps=one.steps,
        seed=1,
        progress=False,
    )
    # the mean of 20 runs of 50 steps, which are correlated
    assert np.mean(result["task_consistency"]) == pytest.approx(1, abs=0.2)
