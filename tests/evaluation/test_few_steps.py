"""Reports on errors name the few steps that make them, and compare the same steps."""

import numpy as np
import pytest

import robsim
from robsim.estimation import estimation_errors
from robsim.trace import Trace

STEPS = 200


@pytest.fixture(scope="module")
def run():
    return robsim.Simulation(control=robsim.DriveAround(), boundary="unlimited").run(STEPS)


def estimated(run, *, wrong=(), unseen=(), bounced=()):
    """The run with estimates 0.1 px off, 5 px off in the wrong steps."""
    generator = np.random.default_rng(2)
    errors = generator.normal(size=(2, STEPS, 3)) * (0.1, 0.1, 0.001)
    errors[0][list(wrong), :2] = 5.0
    estimate, measurement = run.pose_true + errors
    measurement[list(unseen)] = np.nan
    bounces = np.zeros(STEPS, dtype=bool)
    bounces[list(bounced)] = True
    groups = {
        "u": run.u,
        "pose_true": run.pose_true,
        "pose_estimated": estimate,
        "covariance": np.tile(np.diag([0.01, 0.01, 1e-6]), (STEPS, 1, 1)),
        "pose_measured": measurement,
        "bounced": bounces,
    }
    return Trace(groups, run.info)


@pytest.mark.parametrize(
    ("case", "reason"),
    [
        ({"wrong": range(4), "unseen": range(4)}, "4 before the robot was first seen"),
        ({"wrong": (50, 51), "unseen": range(45, 52)}, "2 while it was not seen"),
        ({"wrong": (53, 54), "unseen": range(45, 52)}, "2 within 5 steps after a gap"),
        ({"wrong": (60, 61), "bounced": (59,)}, "2 within 5 steps after a bounce"),
        ({"wrong": (2, 3)}, "2 in the first 10 steps"),
        ({"wrong": (77, 120)}, "2 at step 77, 120"),
    ],
)
def test_the_few_steps_that_make_the_error_are_named_with_their_reason(run, case, reason):
    report = robsim.pose_errors(estimated(run, **case))
    few, compared = report.remarks
    assert f"of x and y: {reason};" in few
    np.testing.assert_array_equal(np.flatnonzero(report.few_steps), case["wrong"])
    rest = np.delete(report.error[0, :, 0], case["wrong"])
    assert f"{np.sqrt(np.square(rest).mean()):.3g} px" in few
    assert "seen" in compared


def test_errors_of_all_steps_have_no_few_ones(run):
    report = robsim.pose_errors(estimated(run))
    assert not report.few_steps.any()
    assert len(report.remarks) == 1
    assert not estimation_errors(np.eye(3)[:2], np.zeros((2, 3))).remarks


def test_an_estimate_and_the_measurement_are_compared_over_the_same_steps(run):
    unseen = range(100, 150)
    report = robsim.pose_errors(estimated(run, wrong=unseen, unseen=unseen))
    (compared,) = report.remarks
    rmse = np.sqrt(np.square(np.delete(report.error[0, :, 0], unseen)).mean())
    assert f"in the 150 steps in which the robot was seen, the rmse is {rmse:.3g} px" in compared
    assert report.rmse[0] > 10 * rmse
    measured = robsim.pose_errors(estimated(run, unseen=unseen), of="measurement")
    assert not measured.remarks
    assert f"{measured.rmse[0]:.3g} px" in compared


def test_steps_of_several_runs_are_named(run):
    reports = robsim.pose_errors([estimated(run), estimated(run, wrong=(77, 120))])
    assert np.argwhere(reports.few_steps).tolist() == [[1, 77], [1, 120]]
    assert "step 77, 120" in reports.remarks[0]
