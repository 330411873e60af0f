"""Kinds of tasks: estimate, follow, identify, measure."""

import numpy as np
import pytest

import robsim
from robsim.estimation import wrapped_error
from robsim.teach import (
    TASKS,
    EstimateTask,
    FollowTask,
    IdentifyTask,
    MeasureTask,
    solution_folder,
)

# --- estimate


@pytest.mark.long
def test_the_told_noise_of_measurements_is_what_they_have():
    for noise in (0, 20):
        one = EstimateTask(noise=noise, dropout=0)
        errors = [
            wrapped_error(trace.pose_measured, trace.pose_true)
            for trace in (one.simulation(seed=seed).run(60) for seed in range(8))
        ]
        told = one.values["MEASUREMENT_SIGMA"]
        assert np.std(np.concatenate(errors), axis=0) == pytest.approx(told, rel=0.1)


def test_a_pose_and_a_covariance_are_scored_by_hand():
    one = EstimateTask(steps=30, dropout=0)
    truth = one.simulation(seed=1).run(30).pose_true

    def estimate_state(step):
        error = (900, 900, 3) if step.k < 10 else (3, 4, 0.1)
        return robsim.Estimate(truth[step.k] + error, np.diag((9.0, 16.0, 0.04)))

    trace = one.simulation(seed=1, estimate_state=estimate_state).run(30)
    assert one.score(trace) == pytest.approx(
        {"position": 5, "heading": np.rad2deg(0.1), "consistency": (1 + 1 + 0.25) / 3}
    )


def test_without_an_estimate_there_is_no_score_and_without_a_covariance_no_consistency():
    one = EstimateTask(steps=20, dropout=0)
    trace = one.simulation(
        seed=1, estimate_state=lambda step: robsim.Estimate((0, 0, 0), np.zeros((3, 3)))
    ).run(20)
    assert np.isnan(one.score(trace)["consistency"])
    assert np.isnan(list(one.score(one.simulation(seed=1).run(20)).values())).all()


@pytest.mark.long
def test_the_reference_is_consistent_with_the_noises_that_are_told():
    one = EstimateTask(slip=1.0, turn=0.03, noise=10)
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


# --- follow


def driven_along(positions, control=lambda step: (0.0, 0.0)):
    """A run that is at these positions."""
    one = FollowTask(waypoints=[(200, 200), (300, 200)], steps=len(positions), dropout=0, noise=0)
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


# --- identify


def run_with(one, theta_of_step):
    return one.simulation(
        seed=1,
        init_parameter_estimator=lambda model: object(),
        estimate_parameters=lambda step: theta_of_step(step.k),
    ).run(one.steps)


def test_each_run_has_a_robot_of_its_own():
    one = IdentifyTask(steps=30)
    thetas = [one.simulation(seed=seed).run(3).info.theta_true for seed in range(3)]
    assert not np.allclose(thetas[0], thetas[1], rtol=0.01)
    assert np.allclose(np.median(thetas, axis=0), one.values["THETA"], atol=0.2)


def test_the_true_parameters_have_no_error_and_others_what_they_predict():
    one = IdentifyTask(steps=30)
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
    one = IdentifyTask(steps=30)
    assert np.isnan(list(one.score(one.simulation(seed=1).run(30)).values())).all()


# --- measure


def test_no_measurement_is_the_worst_there_is():
    one = MeasureTask(steps=12)
    trace = one.simulation(seed=1, measure=lambda step: None).run(one.steps)
    numbers = one.score(trace)
    assert np.isnan(numbers["position"])
    assert np.isnan(numbers["heading"])
    assert numbers["lost"] == 100 * np.mean(~trace.hidden)


def test_errors_and_false_poses_are_scored_by_hand():
    one = MeasureTask(steps=20, dropout=0, noise=0)
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
    one = MeasureTask(steps=12, dropout=1)
    numbers = one.score(one.simulation(seed=1).run(12))
    assert numbers["lost"] == 0


def test_a_sheet_says_what_is_given_and_what_the_world_is():
    sheets = {name: kind().sheet for name, kind in TASKS.items()}
    assert '`identify_from="measurement"`' in sheets["identify"]
    assert "`step.measurement` is None" in sheets["identify"]
    assert not any("identify_from" in sheets[name] for name in sheets.keys() - {"identify"})
    assert all(word in sheets["estimate"] for word in ("at rest", "no walls"))
    assert "while the robot is hidden" in sheets["measure"]
    assert all("does not accept" in sheet and "template" in sheet for sheet in sheets.values())


def test_what_a_sheet_says_of_the_world_is_true():
    run = EstimateTask(slip=0, turn=0, dropout=0).simulation(seed=1).run(400)
    first, second = run.pose_true[:2]
    assert robsim.RobotModel().predict(first, first, run.u[0]) == pytest.approx(second)
    assert run.pose_true[:, :2].min() < 0
    assert run.seen.all()
    samples = []

    def look(step):
        samples.append((step.sample is not None, step.measurement))

    IdentifyTask().simulation(seed=1, estimate_parameters=look).run(5)
    assert samples[-1] == (True, None)


def test_a_pose_for_a_hidden_robot_counts_as_its_error_says():
    task = MeasureTask(steps=20, dropout=0.5)
    run = task.simulation(seed=1).run(20)
    truth, hidden = run.pose_true, run.hidden.astype(bool)
    assert 0 < hidden.sum() < 20

    def scored(offset):
        """Of poses that are true in seen frames, and off in hidden ones."""

        def measure(step):
            return robsim.Measurement(truth[step.k] + [offset * hidden[step.k], 0, 0])

        return task.score(task.simulation(seed=1, measure=measure).run(20))

    assert scored(0) == pytest.approx({"position": 0, "heading": 0, "lost": 0})
    assert scored(5)["position"] == pytest.approx(5 * np.sqrt(hidden.mean()))
    assert scored(50)["lost"] == pytest.approx(100 * hidden.mean())
