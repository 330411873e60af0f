"""Fits to poses of a robot that process noise moves: their standard errors, and the reports."""

import numpy as np
import pytest

import robsim
from robsim.estimation import instrumental_variables, output_error
from robsim.trace import Trace
from sizes import thorough

pytestmark = pytest.mark.kernels

METHODS = {"instrumental_variables": instrumental_variables, "output_error": output_error}
PROCESS = np.array([0.1, 0.1, 0.005])  # px, px, rad in each step
MEASUREMENT = np.array([0.1, 0.1, 0.003])
each_method = pytest.mark.parametrize("method", METHODS)


def drive(seed, level, steps=300, **options):
    """A drive around with this multiple of the process noise, and independent errors of poses."""
    process = robsim.PoseNoise.from_sigma(*level * PROCESS) if level else None
    options = {"boundary": "unlimited", "process_noise": process, "seed": seed, **options}
    trace = robsim.Simulation(control=robsim.DriveAround(), **options).run(steps)
    errors = np.random.default_rng(seed).normal(size=(steps, 3)) * MEASUREMENT
    groups = {name: getattr(trace, name) for name in ("pose_true", "u", "bounced")}
    return Trace(groups | {"pose_measured": trace.pose_true + errors}, trace.info)


def estimate(trace, method, **options):
    return robsim.batch_estimate(trace, identify_from="measurement", method=method, **options)


def rms(values):
    return np.sqrt(np.mean(np.square(values), axis=0))


@pytest.mark.long
@each_method
@pytest.mark.parametrize("level", [0.1, 1, 3])
def test_standard_errors_include_process_noise(method, level):
    seeds = thorough(60, 10)
    found = [estimate(drive(seed, level), method) for seed in range(seeds)]
    z, white = (
        np.array([(fit.batch - fit.theta_true) / getattr(fit, errors) for fit in found])
        for errors in ("standard_errors", "white_noise_errors")
    )
    known = np.isfinite(z)
    covered = (np.abs(z) < 1.96)[known].mean()
    spread = 3.5 * np.sqrt(0.95 * 0.05 / seeds)  # as if the parameters of a run were one
    assert 0.95 - spread < covered < 1
    assert (np.abs(white) < 1.96)[known].mean() < 0.6
    # the same n as the errors show, by a factor of 2
    times = [np.log(fit.standard_errors / fit.white_noise_errors) for fit in found]
    true = np.exp(np.nanmean(np.log(np.sqrt(np.nanmean(np.square(white), axis=0)))))
    assert 0.5 < np.exp(np.nanmean(times)) / true < 2


@pytest.mark.long
def test_white_noise_is_seldom_contradicted():
    found = [estimate(drive(seed, 0, steps=100), "output_error") for seed in range(40)]
    contradicted = [fit.whiteness_p_value < 0.05 for fit in found]
    assert np.sum(contradicted) <= 10  # of 40 with 5 %: more in one of 10^5 times
    for fit, is_contradicted in zip(found, contradicted, strict=True):
        is_same = np.array_equal(fit.standard_errors, fit.white_noise_errors, equal_nan=True)
        assert is_same == (not is_contradicted)


@pytest.mark.long
def test_process_noise_is_found_across_gaps(rng):
    trace = drive(3, 1, steps=600)
    poses = trace.pose_measured.copy()
    poses[rng.random(len(poses)) < 0.5] = np.nan
    fit = output_error(poses, trace.u)
    np.testing.assert_allclose(fit.process_sigma, PROCESS, rtol=0.3)
    np.testing.assert_allclose(fit.measurement_sigma, MEASUREMENT, rtol=0.4)
    still = drive(3, 0, steps=600)
    poses[np.isfinite(poses)] = still.pose_measured[np.isfinite(poses)]
    assert output_error(poses, still.u).whiteness_p_value > 1e-4


def test_exact_poses_show_no_noise():
    trace = drive(1, 0)
    for fit in METHODS.values():
        found = fit(trace.pose_true, trace.u)
        assert found.whiteness_p_value == 1
        np.testing.assert_array_equal(found.process_sigma, 0)


def test_a_path_far_off_has_no_noise_levels():
    trace = drive(1, 0)
    poses = trace.pose_measured.copy()
    poses[150:] *= 1e5
    found = output_error(poses, trace.u)
    assert not found.converged
    assert str(found)


@each_method
def test_a_report_names_the_cause_and_the_better_method(method):
    for level, departure, is_better in (
        (0, "none", False),
        (0.1, "process noise", False),
        (3, "process noise", True),
    ):
        report = estimate(drive(2, level), method)
        assert report.departure == departure
        is_white = level == 0
        assert (report.whiteness_p_value >= 0.05) == is_white
        assert ("not white" in str(report)) == (not is_white)
        assert ("least squares is the better" in str(report)) == is_better
    for options in ({"evaluate_model": robsim.Unicycle()}, {"motor_delay": 0.3}):
        assert estimate(drive(2, 0, **options), method).departure == "mismatch"


@pytest.mark.long
def test_the_errors_of_least_squares_are_foretold():
    for level in (0.3, 3):
        runs = [drive(seed, level) for seed in range(20)]
        least = [estimate(run, "least_squares") for run in runs]
        errors = rms([fit.batch - fit.theta_true for fit in least])
        told = rms([estimate(run, "output_error").least_squares_errors for run in runs[:5]])
        ratio = np.log(told / errors)
        assert abs(ratio.mean()) < np.log(1.5), np.exp(ratio)
        assert np.isnan(least[0].least_squares_errors).all()


def test_noise_levels_have_the_unit_of_the_trace():
    trace = drive(2, 1)
    info = trace.info.as_record() | {"mm_per_px": 2.0}
    in_mm = Trace(
        {name: getattr(trace, name) for name in ("pose_true", "u", "bounced", "pose_measured")},
        robsim.trace.RunInfo(**info),
    ).in_unit("mm")
    px, mm = (estimate(one, "output_error") for one in (trace, in_mm))
    for name in ("process_sigma", "measurement_sigma"):
        np.testing.assert_allclose(getattr(mm, name), getattr(px, name) * (2, 2, 1))
    for name in ("white_noise_errors", "least_squares_errors"):
        ratio = getattr(mm, name) / mm.standard_errors
        np.testing.assert_allclose(ratio, getattr(px, name) / px.standard_errors)


@pytest.mark.long
def test_the_error_of_a_delay_includes_process_noise():
    z = []
    for seed in range(thorough(20, 5)):
        trace = drive(seed, 1, steps=200, motor_delay=1.4)
        fit = output_error(trace.pose_measured, trace.u, motor_delay="fit")
        z.append((fit.motor_delay - 1.4) / fit.motor_delay_error)
    assert rms(z) < 2.5


@pytest.mark.long
def test_a_robot_at_rest_that_process_noise_moves_has_no_error_of_a_delay():
    process = robsim.PoseNoise.from_sigma(*PROCESS)
    control = robsim.Replay(np.zeros((200, 2)))
    trace = robsim.Simulation(control=control, process_noise=process, seed=1).run(200)
    fit = output_error(trace.pose_true, trace.u, motor_delay="fit")
    assert fit.whiteness_p_value < 0.05
    assert fit.motor_delay_error == np.inf
    assert not fit.converged


@pytest.mark.long
@each_method
def test_errors_that_resemble_their_neighbours_are_no_process_noise(method):
    z = []
    for seed in range(thorough(20, 6)):
        trace = drive(seed, 0, steps=800)
        driving = np.random.default_rng(seed).normal(size=(800, 3)) * MEASUREMENT / 5
        errors = np.zeros((800, 3))
        for k in range(1, 800):
            errors[k] = 0.8 * errors[k - 1] + driving[k]
        fit = METHODS[method](trace.pose_true + errors, trace.u)
        assert fit.whiteness_p_value < 0.05
        assert (fit.process_sigma == 0).all()
        assert (fit.measurement_correlation > 0.6).all()
        np.testing.assert_allclose(fit.measurement_sigma, MEASUREMENT / 3, rtol=0.3)
        z.append((fit.theta - np.array(trace.info.theta_true)) / fit.standard_errors)
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.5
