import numpy as np
import pytest

import robsim
from sizes import thorough

pytestmark = pytest.mark.kernels


def driven(steps=800, **options):
    options = {"boundary": "unlimited", "seed": 4, "estimate_parameters": True, **options}
    return robsim.Simulation(control=robsim.DriveAround(), **options).run(steps)


def deviations(estimate, truth):
    """Relative error of a1, a2, b1, b2 and absolute error of d1."""
    relative = np.abs(estimate[:, :4] / truth[:, :4] - 1)
    return relative.max(), np.abs(estimate[:, 4] - truth[:, 4]).max()


def test_batch_and_online_on_true_data_of_a_drive():
    trace = driven(seed=1)
    assert np.abs(np.unwrap(trace.pose_true[:, 2])).max() > 2 * np.pi
    report = robsim.batch_estimate(trace)
    assert (report.start, report.stop) == (0, 800)
    relative, offset = deviations(report.batch, report.theta_true)
    assert relative < 1e-6
    assert offset < 1e-9
    relative, offset = deviations(report.online, report.theta_true)
    assert relative < 1e-4
    assert offset < 1e-6


def bounced(**options):
    options = {"boundary": "bounce", "seed": 1, "estimate_parameters": True, **options}
    control = robsim.DriveAround(low=0.5, high=1.5, hold=3)
    trace = robsim.Simulation(control=control, **options).run(2000)
    assert trace.bounced.sum() > 5
    return trace


def test_a_bounce_ends_the_longest_record_and_does_not_spoil_the_online_estimate():
    trace = bounced()
    report = robsim.batch_estimate(trace, select="longest")
    record = slice(report.start, report.stop)
    assert not trace.bounced[record][1:].any()
    gaps = np.diff(np.concatenate(([0], np.flatnonzero(trace.bounced), [2000])))
    assert report.stop - report.start == gaps.max()
    assert report.n_samples == gaps.max() - 2
    for estimate, limit in ((report.batch, 1e-6), (report.online, 1e-4)):
        assert deviations(estimate, report.theta_true)[0] < limit


def test_valid_samples_are_all_but_those_that_span_a_bounce():
    trace = bounced()
    report = robsim.batch_estimate(trace)
    spoilt = trace.bounced[2:] | trace.bounced[1:-1]
    assert report.n_samples == np.count_nonzero(~spoilt)
    assert report.left_out == np.count_nonzero(spoilt)
    assert f"{report.left_out} samples" in str(report)
    assert deviations(report.batch, report.theta_true)[0] < 1e-6


def test_samples_that_span_a_bounce_spoil_the_estimate():
    trace = bounced()
    report = robsim.batch_estimate(trace, select="all")
    assert (report.n_samples, report.left_out) == (1998, 0)
    assert deviations(report.batch, report.theta_true)[0] > 0.1


def seldom_seen():
    def measure(step):
        return None if step.k in (100, 400) else robsim.Measurement((step.k, 0.0, 0.0))

    return driven(500, measure=measure, resolution=(240, 240))


def test_from_measurements_the_longest_record_has_no_gap():
    report = robsim.batch_estimate(seldom_seen(), identify_from="measurement", select="longest")
    assert (report.start, report.stop) == (101, 400)
    assert "steps 101..399" in report.title


@pytest.mark.parametrize("select", ["valid", "all"])
def test_from_measurements_a_missing_pose_costs_three_samples(select):
    trace = seldom_seen()
    found = robsim.estimation.regression_of(trace, identify_from="measurement", select=select)
    missing = [100, 101, 102, 400, 401, 402]
    np.testing.assert_array_equal(found.k, np.setdiff1d(np.arange(2, 500), missing))
    assert found.left_out == 6
    np.testing.assert_array_equal(found.y[:, 0], found.k)  # x is the number of the step
    np.testing.assert_array_equal(found.phi[:, 0, 0], found.k - 1)
    np.testing.assert_array_equal(found.phi[:, 0, 1], found.k - 2)


def test_a_part_of_a_trace_keeps_its_step_numbers():
    report = robsim.batch_estimate(driven()[200:500])
    assert (report.start, report.stop) == (200, 500)


def test_what_a_record_without_motion_does_not_determine_is_said():
    trace = robsim.Simulation(
        control=lambda step: (0.0, 0.0),
        define_model=lambda: robsim.RobotModel(robsim.RobotParameters(motor_offset=(0.0, 0.0))),
    ).run(50)
    report = robsim.batch_estimate(trace)
    assert (report.rank < 5).all()
    assert np.isnan(report.batch).any()
    assert "a1X, a2X, b1X, b2X, d1X" in str(report)
    assert report.to_dict()["parameters"]["b1X"]["batch"] is None
    assert report.to_dict()["parameters"]["b1X"]["standard_error"] is None
    assert np.isinf(report.standard_errors[0]).all()


def noise_in_the_equation(random):
    def evaluate_model(world):
        pose = world.model.predict(world.pose_1, world.pose_2, world.last_u)
        return pose + random.normal(size=3) * (0.1, 0.1, 0.005)

    return evaluate_model


def test_standard_errors_are_as_large_as_the_noise_makes_them(rng):
    trace = driven(400, evaluate_model=noise_in_the_equation(rng))
    report = robsim.batch_estimate(trace)
    np.testing.assert_allclose(report.residual_rms, (0.1, 0.1, 0.005), rtol=0.15)
    expected = np.array((0.1, 0.1, 0.005))[:, np.newaxis] * report.standard_errors_unscaled
    np.testing.assert_allclose(report.standard_errors, expected, rtol=0.15)
    assert np.abs(report.batch - report.theta_true).max() < 5 * report.standard_errors.max()


@pytest.mark.slow
def test_standard_errors_cover_the_truth():
    theta = robsim.RobotModel().theta
    noise = np.array((0.1, 0.1, 0.005))
    covered = np.zeros((3, 5))
    seeds = thorough(500, 150)
    for seed in range(seeds):
        random = np.random.default_rng(seed)
        u = np.repeat(random.uniform(-0.5, 1.5, size=(80, 2)), 10, axis=0)
        poses = np.zeros((800, 3))
        errors = noise * random.normal(size=poses.shape)
        for k in range(2, 800):
            push = theta[:, 2:4] @ u[k - 1] + theta[:, 4]
            heading = poses[k - 1, 2]
            poses[k] = theta[:, 0] * poses[k - 1] + theta[:, 1] * poses[k - 2] + errors[k]
            poses[k] += push * (np.cos(heading), np.sin(heading), 1)
        info = robsim.trace.RunInfo(dt=0.2, theta_true=theta, boundary="unlimited")
        groups = {"pose_true": poses, "u": u, "bounced": np.zeros(800)}
        report = robsim.batch_estimate(robsim.Trace(groups, info))
        covered += np.abs(report.batch - theta) <= 1.96 * report.standard_errors
    # The mean, and each of them, within three and a half standard errors of a share.
    assert abs(covered.mean() / seeds - 0.95) < 0.02
    assert (np.abs(covered / seeds - 0.95) < 3.5 * np.sqrt(0.95 * 0.05 / seeds)).all()


def test_the_standard_errors_of_recursive_and_batch_estimates_agree():
    trace = driven(300)
    report = robsim.batch_estimate(trace)
    np.testing.assert_allclose(
        trace.standard_errors_unscaled[-1], report.standard_errors_unscaled, rtol=1e-4
    )
    assert np.isnan(trace.standard_errors_unscaled[:2]).all()
    assert (
        np.diff(trace.standard_errors_unscaled[2:], axis=0)
        <= 1e-9 * trace.standard_errors_unscaled[2:-1]
    ).all()


def test_a_robot_that_does_not_move_as_its_model_says_is_noticed(rng):
    options = {"boundary": "bounce", "seed": 3}
    right = robsim.batch_estimate(driven(200, **options))
    assert right.is_model_exact
    assert right.departure == "none"
    assert "true value" in str(right)
    for departure, evaluate_model in (
        ("mismatch", robsim.Unicycle()),
        ("process noise", noise_in_the_equation(rng)),
    ):
        report = robsim.batch_estimate(driven(200, evaluate_model=evaluate_model, **options))
        assert not report.is_model_exact
        assert report.departure == departure
        assert ("true value" in str(report)) == (departure == "process noise")
    np.testing.assert_allclose(report.model_error, (0.1, 0.1, 0.005), rtol=0.2)


def test_a_record_that_is_too_short_or_has_no_poses_is_refused():
    for steps, source, message in (
        (6, "truth", "at least 5 samples"),
        (50, "measurement", "pose_measured"),
        (0, "truth", "pose_true"),
    ):
        with pytest.raises(ValueError, match=message):
            robsim.batch_estimate(robsim.Simulation().run(steps), identify_from=source)
    for name in ("identify_from", "select", "method"):
        with pytest.raises(ValueError, match=name):
            robsim.batch_estimate(robsim.Simulation().run(20), **{name: "guess"})


# --- other methods than least squares


def tracked(**options):
    return driven(600, measure=True, headings=None, resolution=(480, 480), seed=2, **options)


@pytest.fixture(scope="module")
def tracked_run():
    return tracked(identify_from="measurement", noise=robsim.GaussianNoise(10))


@pytest.mark.long
def test_from_measurements_least_squares_is_biased_and_the_others_are_not(tracked_run):
    reports = {
        method: robsim.batch_estimate(tracked_run, method=method)
        for method in ("least_squares", "instrumental_variables", "output_error")
    }
    worst = {
        method: np.abs(report.batch[:, 2:4] / report.theta_true[:, 2:4] - 1).max()
        for method, report in reports.items()
    }
    assert worst["least_squares"] > 0.1
    assert worst["instrumental_variables"] < 0.1
    assert worst["output_error"] < 0.02
    report = reports["output_error"]
    assert report.converged
    assert "output error" in str(report)
    assert (report.rank == 5).all()
    assert np.isnan(report.condition).all()
    assert (report.identifiability.verdicts[:, :4] == "well").all()
    # as from the function itself
    fit = robsim.estimation.output_error(
        tracked_run.pose_measured, tracked_run.u, breaks=tracked_run.bounced
    )
    np.testing.assert_array_equal(report.batch, fit.theta)
    np.testing.assert_array_equal(report.standard_errors, fit.standard_errors)
    np.testing.assert_allclose(report.identifiability.standard_errors, fit.standard_errors)


@pytest.mark.long
def test_bounces_are_breaks_unless_all_samples_are_wanted():
    trace = driven(800, boundary="bounce", start=(150, 150, 3.0), seed=3)
    assert trace.bounced.any()
    right = robsim.batch_estimate(trace, method="output_error")
    wrong = robsim.batch_estimate(trace, method="output_error", select="all")
    assert deviations(right.batch, right.theta_true)[0] < 1e-6
    assert not wrong.converged or deviations(wrong.batch, wrong.theta_true)[0] > 0.01
    part = robsim.batch_estimate(trace, method="output_error", select="longest")
    assert part.stop - part.start < 800
    assert deviations(part.batch, part.theta_true)[0] < 1e-6
