"""The tables beside that of the verdicts: small ones of them."""

from functools import partial

import numpy as np
import pytest

import robsim
import tracked_standard_errors
from nees_of_runs import nees_by_step
from robsim.estimation import reference

pytestmark = pytest.mark.slow


def test_every_filter_is_nearly_consistent_with_the_measurements_of_a_camera():
    model = robsim.RobotModel()
    filters = {
        "extended": partial(reference.ExtendedKalmanFilter, model),
        "unscented": partial(reference.UnscentedKalmanFilter, model),
        "particle": partial(reference.ParticleFilter, model),
        "constant velocity": reference.ConstantVelocityKalmanFilter,
    }
    scenario = robsim.Scenario(
        resolution=(240, 240),
        boundary="unlimited",
        process_noise=robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005),  # that of the defaults
        noise=robsim.GaussianNoise(10),
        headings=None,
        control=robsim.DriveAround(),
        measure=True,
    )
    options = {"runs": 8, "steps": 20, "seed": 0, "on_error": "raise"}
    vary = {"estimate_state": filters}
    result = robsim.campaign(scenario, vary=vary, metrics={"nees": nees_by_step}, **options)
    values = np.stack([result[name] for name in result.metrics], axis=-1)
    means = {name: values[result["estimate_state"] == name].mean() for name in filters}
    assert means["extended"] == pytest.approx(means["unscented"], rel=0.02)
    assert 1 < min(means.values()) < max(means.values()) < 6


def test_least_squares_from_rounded_headings_is_further_off_than_it_says():
    sim = robsim.Simulation(tracked_standard_errors.SCENARIO, seed=1)
    squared = tracked_standard_errors.deviations(sim.run(300))
    assert len(squared) == 9
    assert squared["least_squares_P"] > 3**2
    assert squared["output_error_P"] < 3**2
