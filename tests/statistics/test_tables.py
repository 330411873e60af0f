"""The tables beside that of the verdicts: small ones of them."""

import numpy as np
import pytest

import filter_consistency
import robsim
import tracked_standard_errors

pytestmark = pytest.mark.slow


def test_every_filter_has_a_verdict_on_each_set_of_runs(monkeypatch):
    monkeypatch.setattr(filter_consistency, "RUNS", 4)
    monkeypatch.setattr(filter_consistency, "STEPS", 20)
    found = filter_consistency.verdicts("any heading, 10 %", sets=2, size=240)
    assert list(found) == list(filter_consistency.FILTERS)
    assert all(len(reports) == 2 for reports in found.values())
    means = {name: np.mean([one.values for one in reports]) for name, reports in found.items()}
    assert means["extended"] == pytest.approx(means["unscented"], rel=0.02)
    assert 1 < min(means.values()) < max(means.values()) < 6


def test_least_squares_from_rounded_headings_is_further_off_than_it_says():
    sim = robsim.Simulation(tracked_standard_errors.SCENARIO, seed=1)
    squared = tracked_standard_errors.deviations(sim.run(300))
    assert len(squared) == 9
    assert squared["least_squares_P"] > 3**2
    assert squared["output_error_P"] < 3**2
