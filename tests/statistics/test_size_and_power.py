"""The rates of statistical verdicts, and their tables."""

import json
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
import tracked_standard_errors
from robsim.estimation import reference
from size_and_power import Row, as_json, as_markdown, family_names, measured
from size_and_power.families import doctor
from size_and_power.families.reference_filters import nees_by_step, reports
from sizes import thorough

# --- rates


# With this probability of a false alarm a row, nobody sees one.
NEVER = 1e-6

# Trials of each family; of slow ones a share.
TRIALS = thorough(
    {"nees": 30, "nis": 60, "whiteness": 60}, {"nees": 12, "nis": 25, "whiteness": 25}
)
USUAL = thorough(40, 15)


@pytest.mark.slow
@pytest.mark.kernels
@pytest.mark.parametrize(
    "family", [name for name in family_names() if name != "doctor"]
)  # test_zoo
def test_the_promises_hold(family):
    rows = measured(TRIALS.get(family, USUAL), [family])
    broken = [row for row in rows if row.p_value < NEVER]
    assert not broken, as_markdown(broken)


@pytest.mark.long
def test_a_verdict_that_is_too_strict_is_found(monkeypatch):
    monkeypatch.setattr("robsim.estimation.evaluation.consistency.FRACTION_IN_BAND", 0.98)
    assert min(row.p_value for row in measured(4, ["nees"])) < NEVER


@pytest.mark.long
def test_a_verdict_without_power_is_found(monkeypatch):
    monkeypatch.setattr("robsim.estimation.evaluation._whiteness._LEVEL", 1e-12)
    assert min(row.p_value for row in measured(6, ["whiteness"])) < NEVER


def row(hits, trials, promised):
    one = Row("NEES", "right", "1 run", "rejected", promised)
    return one.counted([True] * hits + [False] * (trials - hits))


def test_a_promise_holds_if_the_interval_meets_it():
    for hits, trials, promised, holds in (
        (0, 10, (0, 0.01), True),
        (5, 100, (0.04, 0.06), True),
        (9, 100, (0.04, 0.06), True),  # 4.2 to 16.4 %
        (12, 100, (0.04, 0.06), False),
        (0, 100, (0.04, 0.06), False),
        (100, 100, (0.99, 1), True),
        (90, 100, (0.99, 1), False),
    ):
        assert row(hits, trials, promised).holds == holds


def test_the_interval_is_that_of_clopper_and_pearson():
    # the exact limits of 0 of n: 0 and 1 - 0.025^(1/n)
    low, high = row(0, 20, (0, 1)).interval
    assert low == 0
    assert high == pytest.approx(1 - 0.025 ** (1 / 20))


def test_only_what_cannot_be_chance_is_a_broken_promise():
    assert row(3, 30, (0, 0.05)).p_value > 0.05
    assert row(25, 30, (0, 0.05)).p_value < 1e-20
    assert row(0, 30, (0.5, 1)).p_value == pytest.approx(0.5**30)
    assert row(2, 30, (0.0, 1)).p_value == 1


def test_trials_are_kept_gone_on_with_and_are_written(tmp_path):
    rows = measured(6, ["whiteness"], keep=tmp_path)
    assert {one.trials for one in rows} == {6}
    assert [file.name for file in tmp_path.iterdir()] == ["whiteness-ljung-box.sqlite"]
    more = measured(9, ["whiteness"], keep=tmp_path)
    assert more == measured(9, ["whiteness"])
    assert len(as_markdown(more).splitlines()) == len(more) + 2
    assert [entry["hits"] for entry in json.loads(as_json(more))] == [one.hits for one in more]


@pytest.mark.long
def test_another_seed_gives_other_trials():
    rows, others = (measured(20, ["whiteness"], seed=seed) for seed in (1, 2))
    assert [one.hits for one in rows] != [one.hits for one in others]


def test_a_trial_of_several_runs_is_counted_once():
    values = np.full((6, 5), 3.0)
    values[3:] = 300.0
    first, second = reports(values, 3)
    assert first.verdict != second.verdict
    assert second.verdict == "optimistic"


def test_the_nees_by_step_leads_to_the_verdict_on_the_runs_themselves():
    traces = [
        robsim.Simulation(
            robot="lab",
            measure=True,
            resolution=(240, 240),
            estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(robsim.RobotModel()),
            seed=seed,
        ).run(30)
        for seed in range(3)
    ]
    values = np.array([list(nees_by_step(trace).values()) for trace in traces])
    (report,) = reports(values, 3)
    expected = robsim.pose_consistency(traces)
    assert report.verdict == expected.verdict
    np.testing.assert_allclose(report.values, expected.values, rtol=1e-12)


def test_a_finding_is_that_of_the_fault_or_the_first():
    dt = "it never uses step.dt"
    for problems, remarks, faults, expected in (
        ([], [], [""], ""),
        (["windup"], [], [""], "windup"),
        (["diverges", "windup"], [], ["windup"], "windup"),
        (["windup"], [], ["diverges"], "windup"),
        (["never heard of"], [], ["windup"], "another"),
        ([], [dt], [f"remark:{dt}"], f"remark:{dt}"),
        ([], [], ["windup"], ""),
    ):
        told = [SimpleNamespace(kind=kind) for kind in problems]
        report = SimpleNamespace(problems=told, remarks=remarks)
        assert doctor.FINDINGS[doctor.finding(report, faults)] == expected


# --- tables


@pytest.mark.slow
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


@pytest.mark.slow
def test_least_squares_from_rounded_headings_is_further_off_than_it_says():
    sim = robsim.Simulation(tracked_standard_errors.SCENARIO, seed=1)
    squared = tracked_standard_errors.deviations(sim.run(300))
    assert len(squared) == 9
    assert squared["least_squares_P"] > 3**2
    assert squared["output_error_P"] < 3**2
