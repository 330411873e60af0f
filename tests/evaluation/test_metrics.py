import json

import numpy as np
import pytest
from scipy import special

import robsim
from robsim.estimation import (
    convergence_time,
    cramer_rao_bound,
    estimation_errors,
    nees,
    nees_consistency,
    nis,
    nis_consistency,
    parameter_bounds,
    parameter_convergence,
    pose_bounds,
    pose_consistency,
    pose_errors,
    posterior_cramer_rao_bound,
    whiteness,
    wrapped_error,
)
from size_and_power.linear_filter import P0, F, H, Q, R, filtered

pytestmark = pytest.mark.kernels

NAN = np.nan
PI = np.pi


def trace_of(pose_true, *, boundary="unlimited", bounced=None, **groups):
    """A trace of these true poses."""
    pose_true = np.asarray(pose_true, dtype=float)
    rows = len(pose_true)
    groups = {
        "pose_true": pose_true,
        "u": np.zeros((rows, 2)),
        "bounced": np.zeros((rows, 1)) if bounced is None else np.asarray(bounced)[:, None],
        **groups,
    }
    info = robsim.trace.RunInfo(dt=0.5, theta_true=robsim.RobotModel().theta, boundary=boundary)
    return robsim.Trace(groups, info)


def driven(steps=60, **options):
    options = {"boundary": "unlimited", "seed": 3, **options}
    return robsim.Simulation(control=robsim.DriveAround(), **options).run(steps)


# errors


def test_the_error_of_a_heading_goes_the_short_way():
    error = wrapped_error([1.0, 5.0, 3.1], [0.0, 7.0, -3.1])
    np.testing.assert_allclose(error, [1.0, -2.0, 6.2 - 2 * PI])
    # (-pi, pi]: half a turn is +pi
    assert wrapped_error([0, 0, PI], [0, 0, 0])[2] == PI
    assert wrapped_error([0, 0, 0], [0, 0, PI])[2] == PI
    np.testing.assert_allclose(
        wrapped_error([[6.0, 6.0]], [0.0, 0.0], angles=[0])[0, 0], 6 - 2 * PI
    )
    assert wrapped_error([7.0], [0.0], angles=()) == 7.0


def test_error_report_against_hand_computed_values():
    truth = np.zeros((4, 3))
    estimate = [[1, 0, 0.1], [-3, 0, 0.1], [NAN, NAN, NAN], [5, 0, 2 * PI - 0.2]]
    report = estimation_errors(estimate, truth)
    np.testing.assert_array_equal(report.known, [3, 3, 3])
    assert report.total == 4
    np.testing.assert_allclose(report.rmse, [np.sqrt(35 / 3), 0, np.sqrt(0.02)])
    np.testing.assert_allclose(report.bias, [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(report.sd, [np.sqrt(32 / 3), 0, np.sqrt(0.02)])
    np.testing.assert_allclose(report.max_error, [5, 0, 0.2])
    np.testing.assert_allclose(report.sd**2 + report.bias**2, report.rmse**2)
    assert np.isnan(report.reported_sd_median).all()


def test_error_report_over_runs():
    truth = np.zeros((2, 3, 1))
    estimate = np.array([[3.0, NAN, 1.0], [4.0, 2.0, NAN]])[..., None]
    report = estimation_errors(estimate, truth, names=["z"], units=["m"], source="student")
    np.testing.assert_array_equal(report.known, [4])
    np.testing.assert_allclose(report.rmse_of_steps[:, 0], [np.sqrt(12.5), 2.0, 1.0])
    np.testing.assert_allclose(report.rmse, np.sqrt(30 / 4))
    assert str(report).splitlines()[0] == "Student minus truth over 2 runs"
    assert "4 (66.7 %)" in str(report)


def test_pose_errors_of_a_trace_agree_with_its_own():
    trace = driven(
        40, measure=lambda step: robsim.Measurement((600, 600, 3)), resolution=(120, 120)
    )
    report = pose_errors(trace, of="measurement")
    np.testing.assert_array_equal(report.error[0], trace.error)
    statistics = trace.tracking()
    error = np.abs(report.error[0])
    assert np.median(np.hypot(*error.T[:2])) == pytest.approx(statistics.median_xy)
    assert np.rad2deg(np.median(error[:, 2])) == pytest.approx(statistics.median_heading_deg)
    np.testing.assert_array_equal(pose_errors(trace[10:], of="measurement").k, np.arange(10, 40))


def refused(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_what_does_not_fit_or_was_not_recorded_is_refused():
    errors = np.ones((10, 3))
    wrong = np.tile(np.eye(2), (4, 1, 1))
    eyes = dict.fromkeys(("Q", "R", "P0"), np.eye(3))
    for call, message in (
        (lambda: wrapped_error(np.ones((2, 3)), errors[:3]), "same shape"),
        (lambda: wrapped_error([1.0, 2.0], [0.0, 0.0]), "angles"),
        (lambda: wrapped_error([np.inf], [0.0], angles=()), "finite"),
        (lambda: estimation_errors([1.0], [0.0], units=["px"], names=["x"]), "shape"),
        (lambda: estimation_errors(errors, errors, covariance=-np.eye(3)), "covariance"),
        (lambda: pose_errors(driven(5), of="guess"), "of"),
        (lambda: pose_errors(driven(5)), "estimate_state"),
        (lambda: pose_errors(driven(5), of="measurement"), "measure=True"),
        (lambda: pose_errors([driven(5), driven(6)]), r"\[5, 6\]"),
        (lambda: pose_consistency(driven(5)), "estimate_state"),
        (lambda: parameter_convergence(driven(5)), "estimate_parameters"),
        (lambda: parameter_bounds(driven(5), sigma=(1.0, 1.0)), "sigma"),
        (lambda: nees(errors, [["a"]]), "covariance"),
        (lambda: nis(errors, np.eye(2)), r"\bS\b.*shape"),
        (lambda: nees(np.array([[1.0, np.inf]]), np.eye(2)), "finite"),
        (lambda: whiteness(np.zeros((50, 1))), "innovation"),
        (lambda: whiteness(np.ones((1, 1))), "innovation"),
        (lambda: cramer_rao_bound([[1, 2], [3]], 1.0), "phi"),
        (lambda: posterior_cramer_rao_bound(1.0, np.eye(3), **eyes, seen=[True] * 4), "shape"),
        (
            lambda: pose_bounds(
                trace_of(np.zeros((4, 3)), boundary="bounce", bounced=[0, 0, 1, 0]), **eyes
            ),
            r"bounce.* step 2",
        ),
        (lambda: pose_bounds(trace_of(np.full((3, 3), NAN)), **eyes), "no pose_true"),
    ):
        refused(call, message)
    for P, message in (
        ([[1.0, 2.0], [2.0, 1.0]], "positive definite"),
        ([[1.0, 0.0], [0.0, 0.0]], "positive definite"),
        ([[1.0, 0.5], [0.0, 1.0]], "symmetric"),
        ([[np.inf, 0.0], [0.0, 1.0]], "finite"),
    ):
        wrong[2] = P
        refused(lambda: nees(np.zeros((4, 2)), wrong), rf"covariance\[2\] must be {message}")
    none = np.zeros((1, 1))
    options = {"Q": none, "R": none, "P0": none, "seen": [True] * 3}
    refused(lambda: posterior_cramer_rao_bound(np.eye(1), np.eye(1), **options), r"\bR must")


# chi-square


def chi_square_band(n, runs=1, level=0.95):
    """The band of the mean of so many values with n degrees of freedom."""
    return 2 * special.gammaincinv(n * runs / 2, [(1 - level) / 2, (1 + level) / 2]) / runs


def test_the_band_is_that_of_the_gamma_distribution():
    for n, runs, level in ((1, 1, 0.5), (2, 50, 0.95), (6, 5000, 0.999)):
        report = nees_consistency(np.ones((runs, 1, n)), np.eye(n), level=level)
        np.testing.assert_allclose(report.band[0], chi_square_band(n, runs, level), rtol=1e-9)
    # Bar-Shalom et al., 5.4.2: 50 runs of 2 degrees of freedom, [1.5, 2.6]
    np.testing.assert_allclose(chi_square_band(2, runs=50), [1.484, 2.591], atol=1e-3)
    for level in (0.0, 1.0):
        with pytest.raises(ValueError, match="level"):
            nees_consistency(np.ones((1, 1, 1)), np.eye(1), level=level)


# NEES and NIS


def test_nees_by_hand():
    # e' P^-1 e with P = [[2, 1], [1, 2]], P^-1 = [[2, -1], [-1, 2]]/3
    assert nees([1.0, 0.0], [[2, 1], [1, 2]]) == pytest.approx(2 / 3)
    assert nees([1.0, 1.0], [[2, 1], [1, 2]]) == pytest.approx(2 / 3)
    assert nis([3.0], [[4.0]]) == pytest.approx(9 / 4)
    values = nees([[1.0, 0.0], [NAN, 0.0], [0.0, 0.0]], np.eye(2))
    np.testing.assert_array_equal(values, [1.0, NAN, 0.0])


def test_the_band_is_wider_where_fewer_runs_are_known():
    error = np.ones((3, 4, 2))
    error[0, 1] = NAN
    error[:, 2] = NAN
    report = nees_consistency(error, np.eye(2))
    np.testing.assert_array_equal(report.counts, [3, 2, 0, 3])
    np.testing.assert_allclose(report.values, [2, 2, NAN, 2])
    np.testing.assert_allclose(report.band[1], special.gammaincinv(2, [0.025, 0.975]))
    assert report.unknown == 4
    assert report.inside == 1.0


def test_shares_and_mean_by_hand():
    # n = 1: the band is 0.00098..5.02
    report = nees_consistency(np.array([[0.0], [1.0], [2.0], [3.0], [NAN]]), [[1.0]])
    assert (report.below, report.inside, report.above) == (0.25, 0.5, 0.25)
    assert report.mean == pytest.approx(14 / 4)
    assert np.isnan(report.mean_standard_error)
    runs = nees_consistency(np.array([[[1.0], [1.0]], [[2.0], [NAN]]]), [[1.0]])
    assert runs.mean == pytest.approx(2.0)  # of the three values that are known
    assert runs.mean_standard_error == pytest.approx(np.std([1, 4], ddof=1) / np.sqrt(2))


def test_a_filter_that_runs_away_is_optimistic_and_nothing_known_is_said():
    report = nees_consistency(1e50 ** np.arange(1, 6)[:, None], [[1.0]])
    assert np.isinf(report.values[-1])
    assert report.verdict == "optimistic"
    report = nees_consistency(np.full((5, 3), NAN), np.eye(3))
    assert report.verdict == "not known"
    assert json.loads(report.to_json())["mean"] is None
    assert nis_consistency(np.ones((3, 1)), np.eye(1)).whiteness is None


def test_nees_of_very_different_units_is_that_of_a_plain_solve():
    rng = np.random.default_rng(5)
    root = rng.normal(size=(50, 3, 3)) * np.array([1e4, 1.0, 1e-5])[:, None]
    P = root @ np.swapaxes(root, 1, 2)
    w = rng.normal(size=(50, 3))
    # e = root w, so e' P^-1 e = w' w
    e = np.einsum("kij,kj->ki", root, w)
    np.testing.assert_allclose(nees(e, (P + np.swapaxes(P, 1, 2)) / 2), (w**2).sum(1), rtol=1e-6)


# a linear filter, right and wrong


def test_a_mean_that_is_off_is_called_with_most_steps_in_the_band():
    # errors 15 % too small in the square: 20 runs, white, so 4 standard errors are 6 %
    rng = np.random.default_rng(6)
    errors = rng.normal(size=(20, 500, 3)) * np.sqrt(0.85)
    report = nees_consistency(errors, np.eye(3))
    assert report.inside > 0.8
    assert report.verdict == "conservative"
    assert nees_consistency(errors[:19], np.eye(3)).verdict == "consistent"
    assert nees_consistency(errors / np.sqrt(0.85), np.eye(3)).verdict == "consistent"


# whiteness


def test_autocorrelation_and_ljung_box_by_hand():
    w = np.array([1.0, -1.0, 2.0, 0.0, 1.0])
    result = whiteness(w[:, None], lags=2)
    square = 7 / 5
    r = [(-1 - 2 + 0 + 0) / 4 / square, (2 + 0 + 2) / 3 / square]
    np.testing.assert_allclose(result.autocorrelation[:, 0], r)
    np.testing.assert_array_equal(result.pairs[:, 0], [4, 3])
    # the textbook's form: N (N + 2) sum rho_k^2/(N - k), rho_k = sum w(t) w(t+k)/sum w(t)^2
    Q = 5 * 7 * ((-3 / 7) ** 2 / 4 + (4 / 7) ** 2 / 3)
    assert result.ljung_box == pytest.approx(Q)
    assert result.p_value == pytest.approx(np.exp(-Q / 2))


def test_no_pair_is_made_with_a_step_that_was_not_seen():
    result = whiteness(np.array([[1.0], [NAN], [2.0], [3.0]]), lags=3)
    np.testing.assert_array_equal(result.pairs[:, 0], [1, 1, 1])
    np.testing.assert_allclose(result.autocorrelation[:, 0], np.array([6, 2, 3]) / (14 / 3))
    # nor across the runs
    runs = whiteness(np.ones((3, 2, 1)), lags=1)
    np.testing.assert_array_equal(runs.pairs, [[3]])


def test_what_is_not_white_is_called():
    rng = np.random.default_rng(9)
    noise = rng.normal(size=(500, 1))
    for values in (noise[1:] + 0.5 * noise[:-1], noise + 0.5, np.cumsum(noise, axis=0)):
        assert not whiteness(values).is_white
    assert "not white" in str(whiteness(noise + 0.5))
    _, _, innovations, S = filtered(1, 500, q=1 / 64, rng=np.random.default_rng(10))
    assert not nis_consistency(innovations[0], S).whiteness.is_white


# convergence


def test_convergence_is_when_the_estimate_enters_and_stays():
    history = np.array([9.0, 1.05, 3.0, 1.05, 0.95, 1.0])
    assert convergence_time(history, 1.0, 0.1) == 3
    assert convergence_time(history, 1.0, 0.1, t=np.arange(6) / 5) == pytest.approx(0.6)
    assert convergence_time(history, 1.0, 10.0) == 0
    assert np.isnan(convergence_time([1.0, 2.0], 1.0, 0.1))
    assert np.isnan(convergence_time([1.0, NAN], 1.0, 0.1))
    assert convergence_time([1.0, NAN, 1.0], 1.0, 0.1) == 2
    both = np.column_stack((history, history[::-1]))
    np.testing.assert_array_equal(convergence_time(both, [1.0, 9.0], [0.1, 0.0]), [3, 5])


def test_parameter_convergence_of_a_run():
    trace = driven(300, estimate_parameters=True)
    report = parameter_convergence(trace[100:])
    near = np.abs(trace.parameters[100:] - report.theta_true) <= report.tolerance
    for axis, parameter in np.ndindex(3, 5):
        row = round(report.time[axis, parameter] / 0.2)
        assert near[row:, axis, parameter].all()
        assert row == 0 or not near[row - 1, axis, parameter]
    expected = [0.019375, 0.009375, 0.0020833, 0.0020833, 1e-3]
    np.testing.assert_allclose(report.tolerance[0], expected, rtol=1e-4)
    assert report.verdict == "converged"
    spun = robsim.Simulation(boundary="unlimited", seed=1, estimate_parameters=True).run(200)
    report = parameter_convergence(spun)
    assert np.isnan(report.time[:2, :4]).any()
    assert report.verdict == "not converged"


def test_online_estimates_from_noisy_poses_are_called_biased():
    options = {"measure": True, "noise": robsim.GaussianNoise(10), "resolution": (480, 480)}
    trace = driven(30, estimate_parameters=True, identify_from="measurement", **options)
    assert "biased" in " ".join(parameter_convergence(trace).remarks)
    assert "output_error" in " ".join(robsim.identifiability(trace).remarks)
    exact = driven(30, estimate_parameters=True)
    assert "biased" not in " ".join(parameter_convergence(exact).remarks)
    assert "output_error" not in " ".join(robsim.identifiability(exact).remarks)


# Cramér-Rao bounds


def test_the_bound_of_a_mean_and_of_a_line():
    np.testing.assert_allclose(
        cramer_rao_bound(np.ones((9, 1)), 3.0)[:, 0], 3 / np.sqrt(np.arange(1, 10))
    )
    phi = np.column_stack((np.arange(50.0), np.ones(50)))
    bound = cramer_rao_bound(phi, 0.2)
    np.testing.assert_allclose(bound[0], [np.inf, 0.2])
    for k in (1, 7, 49):
        covariance = 0.04 * np.linalg.inv(phi[: k + 1].T @ phi[: k + 1])
        np.testing.assert_allclose(bound[k], np.sqrt(np.diag(covariance)), rtol=1e-9)

    # theta0 + theta1 and theta2 are seen
    phi = np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0], [NAN, 1.0, 5.0]])
    bound = cramer_rao_bound(phi, 1.0)
    np.testing.assert_allclose(bound[2:], [[np.inf, np.inf, 0.5]] * 2)


def test_parameter_bounds_of_a_drive():
    trace = driven(200)
    sigma = np.array([0.1, 0.2, 0.005])
    bounds = parameter_bounds(trace, sigma=sigma)
    assert bounds.shape == (200, 3, 5)
    assert np.isinf(bounds[:2]).all()
    phi, _ = robsim.estimation.regression(trace.pose_true, trace.u)
    for axis in range(3):
        Phi = phi[:, axis]
        # the pseudo-inverse of columns of length 1 is well enough conditioned
        length = np.linalg.norm(Phi, axis=0)
        rows = np.linalg.pinv(Phi / length) / length[:, None]
        np.testing.assert_allclose(
            bounds[-1, axis], sigma[axis] * np.linalg.norm(rows, axis=1), rtol=1e-6
        )
    assert (np.diff(bounds[50:], axis=0) <= 1e-9 * bounds[50:-1]).all()


def test_samples_across_a_bounce_say_nothing():
    control = robsim.DriveAround(low=0.5, high=1.5, hold=3)
    trace = robsim.Simulation(control=control, seed=1).run(300)
    bounds = parameter_bounds(trace, sigma=(0.1, 0.1, 0.005))
    k = int(np.flatnonzero(trace.bounced & (trace.k > 100))[0])
    np.testing.assert_allclose(bounds[k : k + 2], bounds[[k - 1, k - 1]])
    assert (bounds[k + 2] < bounds[k + 1]).any()


def information_form(seen):
    """The recursion as Tichavsky et al. write it, with D11, D12 and D22."""
    J = np.linalg.inv(P0)
    J = J + H.T @ np.linalg.inv(R) @ H if seen[0] else J
    yield np.linalg.inv(J)
    inverse = np.linalg.inv(Q)
    for is_seen in seen[1:]:
        D11 = F.T @ inverse @ F
        D12 = -F.T @ inverse
        D22 = inverse + (H.T @ np.linalg.inv(R) @ H if is_seen else 0.0)
        J = D22 - D12.T @ np.linalg.inv(J + D11) @ D12
        yield np.linalg.inv(J)


def test_the_posterior_bound_agrees_with_the_form_of_the_paper():
    seen = np.random.default_rng(14).random(80) < 0.6
    seen[0] = False
    bounds = posterior_cramer_rao_bound(F, H, Q=Q, R=R, P0=P0, seen=seen)
    np.testing.assert_allclose(bounds, list(information_form(seen)), rtol=1e-10)
    each = posterior_cramer_rao_bound(np.tile(F, (79, 1, 1)), H, Q=Q, R=R, P0=P0, seen=seen)
    np.testing.assert_array_equal(each, bounds)


def test_the_derivative_of_the_robot_model_in_the_bound():
    trace = driven(30)
    R3 = np.diag([0.25, 0.25, 0.01])
    Q3 = np.diag([0.01, 0.04, 1e-4])
    start = np.diag([4.0, 4.0, 0.1, 5.0, 5.0, 0.2])
    bounds = pose_bounds(trace, Q=Q3, R=R3, P0=start)
    model = robsim.RobotModel()

    def step(state, u):
        return np.concatenate((model.predict(state[:3], state[3:], u), state[:3]))

    P, H6, noise = start, np.eye(3, 6), np.zeros((6, 6))
    noise[:3, :3] = Q3
    for k in range(30):
        if k > 0:
            before = trace.pose_true[max(k - 2, 0)]
            state = np.concatenate((trace.pose_true[k - 1], before))
            ends = [
                [step(state + sign * d, trace.u[k - 1]) for d in 1e-5 * np.eye(6)]
                for sign in (1, -1)
            ]
            derivative = (np.array(ends[0]) - ends[1]).T / 2e-5
            P = derivative @ P @ derivative.T + noise
        P = np.linalg.inv(np.linalg.inv(P) + H6.T @ np.linalg.inv(R3) @ H6)
        np.testing.assert_allclose(bounds[k], P[:3, :3], rtol=1e-5, atol=1e-10)


def test_steps_without_a_measurement_do_not_count():
    def measure(step):
        return None if step.k >= 5 else robsim.Measurement((0, 0, 0))

    trace = driven(10, measure=measure, resolution=(120, 120))
    options = {"Q": np.diag([0.1, 0.1, 0.01]), "R": np.eye(3), "P0": np.eye(3)}
    bounds = pose_bounds(trace, **options)
    assert (np.diff(bounds[4:, 0, 0]) > 0).all()
    untracked = trace_of(trace.pose_true, u=trace.u)
    np.testing.assert_array_equal(pose_bounds(untracked, **options)[:5], bounds[:5])
    assert (pose_bounds(untracked, **options)[5:, 0, 0] < bounds[5:, 0, 0]).all()


# a trace with estimates


def estimated(runs, *, reported_sd=1.0):
    """Runs whose estimates have the covariance diag(4, 4, 0.01), and claim it times a factor."""
    rng = np.random.default_rng(15)
    P = np.diag([4.0, 4.0, 0.01])
    pose_true = np.column_stack((np.arange(100.0), np.zeros(100), np.full(100, PI - 0.01)))
    for _ in range(runs):
        poses = pose_true + rng.multivariate_normal(np.zeros(3), P, 100)
        poses[:, 2] = robsim.wrap_angle(poses[:, 2])
        covariance = np.broadcast_to(reported_sd * P, (100, 3, 3))
        yield trace_of(pose_true, pose_estimated=poses, covariance=covariance)


def test_consistency_and_errors_of_traces():
    assert pose_consistency(next(estimated(1))).verdict == "consistent"
    report = pose_consistency(list(estimated(20)))
    assert report.verdict == "consistent"
    assert (report.n, report.runs, len(report.values)) == (3, 20, 100)
    assert pose_consistency(list(estimated(20, reported_sd=4))).verdict == "conservative"
    report = pose_consistency(list(estimated(20, reported_sd=0.25)))
    assert report.verdict == json.loads(report.to_json())["verdict"] == "optimistic"
    assert "too sure" in report.remarks[0]
    part = pose_consistency(next(estimated(1))[30:])
    np.testing.assert_array_equal(part.k, np.arange(30, 100))
    report = pose_errors(list(estimated(20)))
    np.testing.assert_allclose(report.reported_sd_median, [2, 2, 0.1])
    np.testing.assert_allclose(report.rmse, [2, 2, 0.1], rtol=0.05)
    heading = json.loads(report.to_json())["errors"]["heading"]
    assert (heading["unit"], heading["known"]) == ("rad", 2000)
