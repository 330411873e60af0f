"""The task to measure in noise: its scores, its solutions, its sheet."""

import numpy as np
import pytest

import robsim
from robsim.tasks import TASKS, Measure, task


def campaign_of(one, solutions, runs):
    return robsim.campaign(
        one.scenario,
        vary={"folder": {solution.name: solution.choice(one) for solution in solutions}},
        metrics={"task": one.score},
        runs=runs,
        steps=one.steps,
        seed=3,
        progress=False,
    )


def test_a_task_by_name_is_that_of_its_class():
    assert task("measure", noise=20, steps=10) == Measure(noise=20, steps=10)
    assert Measure(**Measure(noise=20).parameters) == Measure(noise=20)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: task("mesure"), "there is no task 'mesure': did you mean 'measure'?"),
        (lambda: task("measure", nois=3), "Measure has no option 'nois': did you mean 'noise'?"),
        (lambda: Measure(noise=-1), "noise must lie within 0..100"),
        (lambda: Measure(dropout=2), "dropout must lie within 0..1"),
        (lambda: Measure(steps=0), "steps must lie within 1.."),
    ],
)
def test_what_is_wrong_is_named(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


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


@pytest.mark.parametrize("name", TASKS)
def test_shares_sum_to_1_and_scores_are_those_of_runs(name):
    one = task(name, steps=20)
    assert sum(score.share for score in one.scores) == pytest.approx(1)
    reference = one.solutions[0]
    assert (reference.name, reference.is_right) == ("reference", True)
    row = campaign_of(one, [reference], 1)
    assert row["error"].tolist() == [None]
    assert {score.name for score in one.scores} == {
        column.removeprefix("task_") for column in row.columns if column.startswith("task_")
    }


def test_right_solutions_are_near_the_reference_and_wrong_ones_are_not():
    one = Measure(steps=40)
    result = campaign_of(one, one.solutions, 4)
    numbers = {
        solution.name: [
            score.statistic(
                result[f"task_{score.name}"][result["folder"] == solution.name],
                result[f"task_{score.name}"][result["folder"] == "reference"],
            )
            for score in one.scores
        ]
        for solution in one.solutions
    }
    right = [numbers[solution.name] for solution in one.solutions if solution.is_right]
    best_wrong = np.max(right, axis=0) * 1.1
    for solution in one.solutions:
        assert (numbers[solution.name] > best_wrong).any() != solution.is_right, solution


def test_the_sheet_has_the_values_and_the_scores():
    text = Measure(noise=17).sheet
    assert "17 %" in text
    assert "| `NOISE` | `17` |" in text
    assert "| error of the position | px | 40 % |" in text
    assert "`robsim.reference`" in text
    assert "robsim tasks try measure mine" in text
