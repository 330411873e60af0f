"""Identification with late inputs and lost frames."""

import functools
import importlib

import numpy as np
import pytest
from scipy import stats

import robsim
from robsim.estimation import instrumental_variables, output_error, regression_of
from robsim.trace import Trace
from sizes import thorough

# --- late inputs


TRUTH = robsim.RobotModel().theta
NOISE = np.array([0.3, 0.3, 0.01])  # px, px, rad
METHODS = ["least_squares", "instrumental_variables", "output_error"]
each_method = pytest.mark.parametrize("method", METHODS)


def late_run(seed=1, delay=2.4, steps=300, **options):
    """A drive around whose inputs act late."""
    u = np.random.default_rng(seed).uniform(-0.5, 1.5, (-(-steps // 5), 2))
    return robsim.Simulation(
        control=robsim.Replay(np.repeat(u, 5, axis=0)[:steps]),
        motor_delay=delay,
        seed=seed,
        **({"boundary": "unlimited"} | options),
    ).run(steps)


def measured(trace, seed=7, sigma=NOISE):
    return trace.pose_true + np.random.default_rng(seed).normal(size=(len(trace), 3)) * sigma


def gain_errors(theta):
    """Relative errors of b1 and b2, the largest of all axes."""
    return np.nanmax(np.abs(theta / np.where(TRUTH, TRUTH, np.nan) - 1)[:, 2:4])


@pytest.mark.kernels
@pytest.mark.long
@each_method
@pytest.mark.parametrize("delay", [0, 2.4, 40.5])
def test_the_true_delay_gives_back_the_true_parameters(method, delay):
    trace = late_run(delay=delay)
    found = robsim.batch_estimate(trace, method=method, motor_delay=delay)
    np.testing.assert_allclose(found.batch, TRUTH, rtol=0, atol=1e-6)
    assert found.is_model_exact
    assert (found.motor_delay, found.motor_delay_error) == (delay, 0)
    if delay:
        without = robsim.batch_estimate(trace, method=method)
        assert without.motor_delay == 0
        assert not without.is_model_exact
        # on truth: 0.05 to 2 and more
        assert gain_errors(without.batch) > 0.04


@pytest.mark.kernels
@pytest.mark.parametrize("fit", [output_error, instrumental_variables])
def test_noise_adds_no_bias_to_a_fit_that_knows_the_delay(fit):
    trace = late_run()
    z = measured(trace)
    found, without = fit(z, trace.u, motor_delay=2.4), fit(z, trace.u)
    within = np.abs(found.theta - TRUTH) / found.standard_errors
    assert within[found.determined].max() < 5
    beyond = np.abs(without.theta - TRUTH) / without.white_noise_errors
    assert beyond[without.determined].max() > 8
    assert without.whiteness_p_value < 1e-3 < found.whiteness_p_value


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.parametrize("delay", [2.4, 0.0])
def test_the_delay_is_estimated_and_the_parameters_with_it(delay):
    trace = late_run(delay=delay)
    found = output_error(measured(trace), trace.u, motor_delay="fit")
    assert found.converged
    assert 0.001 < found.motor_delay_error < 0.02
    assert abs(found.motor_delay - delay) < 4 * found.motor_delay_error
    assert (np.abs(found.theta - TRUTH) < 5 * found.standard_errors)[found.determined].all()
    given = output_error(measured(trace), trace.u, motor_delay=delay)
    assert (found.standard_errors >= given.standard_errors * 0.9)[found.determined].all()
    assert "motor delay" in str(found)


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.parametrize("delay", [0.0, 0.5, 1.4, 2.0, 3.7, 9.5])
def test_no_other_delay_fits_better_than_the_one_found(delay):
    trace = late_run(delay=delay, steps=200)
    z = measured(trace)
    found = output_error(z, trace.u, motor_delay="fit")
    apart = np.array([-3, -1, -0.1, 0.1, 1, 3]) * found.motor_delay_error
    for other in np.append(found.motor_delay + apart, range(11)).clip(0, 10):
        fit = output_error(z, trace.u, motor_delay=other)
        # -2 log likelihood, whose fits end 1e-2 standard errors from the best one
        cost, best = (2 * len(trace) * np.log(one.residual_rms).sum() for one in (fit, found))
        assert cost > best - 1e-3


@pytest.mark.kernels
def test_the_search_for_a_delay_begins_a_few_fits_anew(monkeypatch):
    module = importlib.import_module("robsim.estimation.identification.fits.output_error")
    begun = []
    start = module.initial_estimate
    monkeypatch.setattr(module, "initial_estimate", lambda *given: begun.append(1) or start(*given))
    trace = late_run(steps=150)
    output_error(measured(trace), trace.u, motor_delay="fit")
    assert len(begun) <= 3


def test_too_few_poses_for_a_delay_are_told():
    with pytest.raises(ValueError, match="at least 8 poses"):
        output_error(np.zeros((5, 3)), np.zeros((5, 2)), motor_delay="fit")


@pytest.mark.kernels
@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.6, 3])
def test_the_standard_error_of_the_delay_is_honest(delay):
    errors = []
    for seed in range(thorough(8, 4)):
        trace = late_run(seed, delay, steps=200)
        fit = output_error(measured(trace, seed), trace.u, motor_delay="fit")
        errors.append((fit.motor_delay - delay) / fit.motor_delay_error)
    low, high = stats.chi2.ppf((0.001, 0.999), len(errors))
    assert low < np.square(errors).sum() < high


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "departure"), [({}, "none"), ({"evaluate_model": robsim.Unicycle()}, "mismatch")]
)
def test_a_batch_estimate_estimates_the_delay_from_measured_poses(options, departure):
    trace = late_run(delay=1.7, boundary="bounce", steps=250, **options)
    groups = {name: getattr(trace, name) for name in ("pose_true", "u", "bounced")}
    seen = Trace(groups | {"pose_measured": measured(trace)}, trace.info)
    found = robsim.batch_estimate(
        seen, identify_from="measurement", method="output_error", motor_delay="fit"
    )
    assert abs(found.motor_delay - 1.7) < 4 * found.motor_delay_error < 0.2
    assert found.to_dict()["motor_delay"] == found.motor_delay
    # The model errs by as much as the delay is wrong: that is no departure of the robot.
    assert (found.model_error > 0).all()
    assert found.departure == departure
    assert ("the robot does not move as its model" in str(found)) == (departure == "mismatch")


@pytest.mark.kernels
@pytest.mark.long
def test_a_delay_beyond_what_is_searched_is_no_result():
    trace = late_run(delay=14, steps=150)
    found = output_error(measured(trace), trace.u, motor_delay="fit")
    assert not found.converged


# --- where the inputs that act are not known


@pytest.mark.kernels
def test_a_part_of_a_run_begins_where_its_inputs_are_known():
    trace = late_run(delay=2.4)
    part = trace[100:]
    samples = regression_of(part, motor_delay=2.4)
    assert samples.k[0] == 100 + 3 + 2  # the inputs of 100.. act alone from step 103 on
    for method in METHODS:
        found = robsim.batch_estimate(part, method=method, motor_delay=2.4)
        np.testing.assert_allclose(found.batch, TRUTH, rtol=0, atol=1e-6)
    # from the start of the run on all is known: before it the inputs were 0
    assert regression_of(trace, motor_delay=2.4).k[0] == 2


@pytest.mark.kernels
@pytest.mark.parametrize("group", ["interrupted", "t"])
def test_for_so_long_after_lost_frames_and_stops_no_sample_is_valid(group):
    trace = late_run(delay=2.4, steps=60)
    groups = {name: getattr(trace, name) for name in ("pose_true", "u", "bounced")}
    if group == "interrupted":
        values = np.arange(60) == 30
    else:
        values = np.arange(60) * 0.2 + 0.4 * (np.arange(60) >= 30)
    broken = Trace(groups | {group: values}, trace.info)
    prompt, late = regression_of(broken), regression_of(broken, motor_delay=2.4)
    assert sorted(set(trace.k[2:]) - set(prompt.k)) == [30, 31]
    assert sorted(set(trace.k[2:]) - set(late.k)) == [30, 31, 32, 33, 34]
    assert late.left_out == 5


@pytest.mark.kernels
def test_after_a_bounce_the_inputs_are_known():
    trace = late_run(delay=2.4, boundary="bounce", start=(1100, 600, 0.0), steps=400)
    bounces = np.flatnonzero(trace.bounced)
    assert len(bounces)
    samples = regression_of(trace, motor_delay=2.4)
    assert bounces[0] + 2 in samples.k
    found = robsim.batch_estimate(trace, motor_delay=2.4)
    np.testing.assert_allclose(found.batch, TRUTH, rtol=0, atol=1e-6)


# --- wrong arguments


@pytest.mark.kernels
def test_a_delay_has_limits_and_is_fitted_by_output_error_alone():
    trace = late_run(steps=30)
    for method in METHODS:
        for delay in (-0.01, 1000.01):
            with pytest.raises(ValueError, match="motor_delay"):
                robsim.batch_estimate(trace, method=method, motor_delay=delay)
    with pytest.raises(ValueError, match="motor_delay"):
        robsim.batch_estimate(trace, method="output_error", motor_delay="fitted")
    with pytest.raises(ValueError, match="output_error"):
        robsim.batch_estimate(trace, motor_delay="fit")


# --- lost frames


DT = 0.2
B1X = 2


@functools.cache
def driven(steps):
    """Return the frames of a drive around, and its inputs."""
    sim = robsim.Simulation(
        headings=None,
        resolution=(300, 300),
        # errors that do not depend on the place, as the standard errors take them to be
        noise=robsim.GaussianNoise(10),
        control=robsim.DriveAround(),
        seed=3,
    )
    frames = [sim.step().frame for _ in range(steps)]
    assert not sim.trace.bounced.any()
    return frames, sim.trace


def without(lost, steps):
    """Return the trace of the frames that are left; their times start at one dt."""
    frames, simulated = driven(steps)
    kept = np.setdiff1d(np.arange(steps), lost)
    timed = [
        robsim.Frame(frames[k].image, t=DT * (k + 1), index=k, plane_map=frames[k].plane_map)
        for k in kept
    ]
    sim = robsim.Experiment(timed, control=lambda step: simulated.u[step.frame.index])
    return sim.run()


def exact(lost, steps):
    """Return a run with true poses that has lost steps."""
    run = robsim.Simulation(boundary="unlimited", control=robsim.DriveAround(), seed=3).run(steps)
    kept = np.setdiff1d(np.arange(steps), lost)
    groups = {"t": run.t, "pose_true": run.pose_true, "u": run.u, "bounced": run.bounced}
    return robsim.Trace({name: rows[kept] for name, rows in groups.items()}, run.info)


def tenth_of(steps):
    return np.random.default_rng(1).choice(np.arange(1, steps), steps // 10, replace=False)


def check_b1x(report, share):
    b1x = robsim.RobotModel().theta[0, B1X]
    error = abs(report.batch[0, B1X] - b1x)
    assert error < share * b1x
    assert error < 4 * report.standard_errors[0, B1X]


@pytest.mark.long
@pytest.mark.parametrize(
    ("method", "share"), [("output_error", 0.02), ("instrumental_variables", 0.05)]
)
def test_lost_frames_do_not_spoil_the_unbiased_methods(method, share):
    report = robsim.batch_estimate(without(tenth_of(600), 600), method=method)
    assert report.converged
    check_b1x(report, share)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("select", ["valid", "all"])
def test_exact_poses_with_gaps_give_back_the_parameters(method, select):
    report = robsim.batch_estimate(exact(tenth_of(600), 600), method=method, select=select)
    np.testing.assert_allclose(report.batch, robsim.RobotModel().theta, atol=1e-6)


@pytest.mark.long
def test_a_lost_frame_costs_the_samples_that_span_it():
    trace = without([20], 40)
    found = robsim.estimation.regression_of(trace)
    # Of 39 steps 0..38, step 20 comes two dt after step 19.
    np.testing.assert_array_equal(found.k, np.setdiff1d(np.arange(2, 39), [20, 21]))
    assert found.left_out == 2
    longest = robsim.estimation.regression_of(trace, select="longest")
    np.testing.assert_array_equal(longest.k, np.arange(2, 20))
    assert "2 samples with a bounce, a missing pose or lost frames" in str(
        robsim.batch_estimate(trace)
    )


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_time_that_is_no_multiple_of_dt_is_refused(method):
    trace = exact([], 40)
    times = trace.t + np.where(trace.k < 20, 0, DT / 3)
    groups = {"t": times, "pose_true": trace.pose_true, "u": trace.u, "bounced": trace.bounced}
    trace = robsim.Trace(groups, trace.info)
    with pytest.raises(ValueError, match=r"must be a multiple of the model's dt, 0.2 s, got 0.266"):
        robsim.batch_estimate(trace, method=method)
