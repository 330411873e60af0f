"""The fits without the bias of least squares."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from robsim._core import second_order_recursion
from robsim.estimation import instrumental_variables, output_error
from sizes import thorough

pytestmark = pytest.mark.kernels

TRUTH = robsim.RobotModel().theta
NOISE = np.array([0.3, 0.3, 0.01])  # px, px, rad
METHODS = {"instrumental_variables": instrumental_variables, "output_error": output_error}
each_method = pytest.mark.parametrize("fit", METHODS.values(), ids=METHODS)


def plain_path(theta, first, u):
    """The model's equations, step by step."""
    path = [np.array(pose, dtype=float) for pose in first]
    for k in range(2, len(u)):
        heading = path[k - 1][2]
        direction = np.array([np.cos(heading), np.sin(heading), 1])
        force = theta[:, 2] * u[k - 1, 0] + theta[:, 3] * u[k - 1, 1] + theta[:, 4]
        path.append(theta[:, 0] * path[k - 1] + theta[:, 1] * path[k - 2] + force * direction)
    return np.array(path)


def drive(seed, steps=800, low=-0.5, high=1.5, hold=10):
    """True path, inputs and noise of a drive around."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.uniform(low, high, (-(-steps // hold), 2)), hold, axis=0)[:steps]
    path = plain_path(TRUTH, [(600, 600, 0.1), (600, 600, 0.1)], u)
    return path, u, rng.normal(size=path.shape) * NOISE


def wrapped(poses):
    return np.column_stack([poses[:, :2], robsim.wrap_angle(poses[:, 2])])


def deviations(theta):
    """Relative error of a1, b1 and b2 of each axis."""
    return (theta / np.where(TRUTH, TRUTH, np.nan) - 1)[..., [0, 2, 3]]


def assert_honest(fit, errors=5):
    """All that is given lies within some standard errors of the truth."""
    there = fit.determined
    assert (np.abs(fit.theta - TRUTH)[there] < errors * fit.standard_errors[there]).all()
    assert np.isinf(fit.standard_errors[~there]).all()


# --- the filter 1/A


def test_the_recursion_is_that_of_a_plain_loop(rng):
    for a in ((1.9375, -0.9375), (0.5, -0.9), (0.0, 0.0)):
        for steps in (1, 2, 3, 8, 37):
            force = rng.normal(size=(steps, 3))
            expected = np.zeros((steps + 2, 3))
            for k in range(steps):
                expected[k + 2] = a[0] * expected[k + 1] + a[1] * expected[k] + force[k]
            found = second_order_recursion(*a, force)
            np.testing.assert_allclose(found, expected[2:], rtol=1e-15, atol=1e-15)


# --- exact and noisy data


@pytest.mark.long
@each_method
def test_exact_data_give_back_the_truth(fit):
    path, u, _ = drive(1)
    assert np.abs(path[:, 2]).max() > np.pi
    result = fit(wrapped(path), u)
    assert result.converged
    assert result.determined.all()
    np.testing.assert_allclose(result.theta, TRUTH, rtol=0, atol=1e-8)


def many_seeds(fit, seeds):
    results = []
    for seed in range(seeds):
        path, u, noise = drive(seed)
        results.append(fit(wrapped(path + noise), u))
    assert all(result.converged for result in results)
    theta = np.array([result.theta for result in results])
    errors = np.array([result.standard_errors for result in results])
    return theta, np.abs(theta - TRUTH) < 1.96 * errors


def check_means(fit, seeds, limit_of_b):
    theta, covered = many_seeds(fit, seeds)
    mean = np.abs(deviations(theta).mean(axis=0))
    assert (mean[:, 0] < 1e-3).all(), mean
    assert (mean[:, 1:] < limit_of_b).all(), mean
    return covered


@pytest.mark.long
@pytest.mark.parametrize(
    ("fit", "limit_of_b"),
    [(instrumental_variables, 0.015), (output_error, 0.001)],
    ids=METHODS,
)
def test_the_fits_are_not_and_their_standard_errors_cover_the_truth(fit, limit_of_b):
    seeds = thorough(100, 20)
    covered = check_means(fit, seeds, limit_of_b)
    assert 0.88 < covered.mean() < 0.99
    # Three standard deviations of the share among the seeds.
    assert (covered.mean(axis=0) > 0.95 - 3 * np.sqrt(0.95 * 0.05 / seeds)).all()


# --- gaps and breaks


@pytest.mark.long
@pytest.mark.parametrize("share", [0.1, 0.7])
def test_output_error_bridges_gaps(share, rng):
    path, u, noise = drive(5)
    poses = wrapped(path + noise)
    poses[rng.random(len(poses)) < share] = np.nan
    result = output_error(poses, u)
    assert result.converged
    assert result.determined.all()
    assert_honest(result)
    assert np.abs(deviations(result.theta)).max() < 0.01


@each_method
def test_in_a_gap_the_robot_may_turn_by_any_angle(fit):
    path, u, noise = drive(21)
    poses = wrapped(path + noise)
    poses[100:200] = np.nan
    poses[350:600] = np.nan
    assert abs(path[600, 2] - path[350, 2]) > np.pi
    result = fit(poses, u)
    assert result.converged
    assert result.determined.all()
    assert_honest(result)


@pytest.mark.long
@each_method
def test_a_break_starts_a_new_stretch(fit):
    parts = [drive(seed, steps) for seed, steps in ((1, 300), (2, 40), (3, 2), (4, 400))]
    u = np.vstack([u for _, u, _ in parts])
    poses = wrapped(np.vstack([path - (50 * i, 0, 0) for i, (path, _, _) in enumerate(parts)]))
    breaks = np.zeros(len(u), dtype=bool)
    breaks[[300, 340, 342]] = True
    np.testing.assert_allclose(fit(poses, u, breaks=breaks).theta, TRUTH, rtol=0, atol=1e-8)
    noisy = poses + np.vstack([noise for _, _, noise in parts])
    result = fit(noisy, u, breaks=breaks)
    assert result.converged
    assert result.determined.all()
    assert_honest(result)


# --- what cannot be given is not given


def noisy_run(control, seed, steps=800):
    sim = robsim.Simulation(boundary="unlimited", control=control, resolution=(120, 120), seed=seed)
    trace = sim.run(steps)
    noise = np.random.default_rng(seed).normal(size=(steps, 3)) * NOISE
    return wrapped(trace.pose_true + noise), trace.u


@pytest.mark.long
@each_method
def test_a_spin_says_nothing_about_x_and_y(fit):
    result = fit(*noisy_run(robsim.Spin(), 1))
    assert not result.determined[:2].any()
    assert not result.determined[2, 2:].any()  # u1 = -u2, always the same: one number for three
    assert_honest(result)
    assert str(result).splitlines()[3].split() == ["a1X", "-", "-"]


@pytest.mark.long
@each_method
def test_constant_inputs_determine_no_force(fit):
    for voltages in ((0.0, 0.0), (0.5, 0.4)):
        result = fit(*noisy_run(lambda step, u=voltages: u, 1))
        assert not result.determined[:, 2:].any()


@each_method
def test_one_motor_determines_all_but_the_other(fit):
    rng = np.random.default_rng(0)
    result = fit(*noisy_run(lambda step: (0.0, rng.uniform(-1, 1)), 1))
    expected = np.ones((3, 5), dtype=bool)
    expected[:, 2] = False
    np.testing.assert_array_equal(result.determined, expected)
    assert result.converged
    assert_honest(result)


@pytest.mark.long
@each_method
def test_weak_inputs_give_no_wrong_number(fit):
    for size in (0.01, 0.1):
        for seed in range(1, thorough(4, 2)):
            poses, u = noisy_run(robsim.DriveAround(low=-0.5 * size, high=1.5 * size), seed)
            assert_honest(fit(poses, u))


@pytest.mark.long
@each_method
def test_a_short_record_gives_no_wrong_number(fit):
    for steps in (14, 20, 40, 60):
        for seed in range(thorough(3, 2)):
            path, u, noise = drive(seed, steps)
            assert_honest(fit(wrapped(path + noise), u))


def test_a_robot_carried_by_hand_is_no_silent_number():
    path, u, noise = drive(1)
    poses = path + noise
    poses[300:] += (400, -300, 2)
    poses[500:] += (-200, 100, 1)
    result = output_error(wrapped(poses), u)
    assert not result.converged


# --- what does not fit


@each_method
def test_a_record_that_is_too_short_is_refused(fit):
    path, u, _ = drive(1, steps=9)
    with pytest.raises(ValueError, match="at least 8"):
        fit(path, u)
    with pytest.raises(ValueError, match="at least 8"):
        fit(np.full((50, 3), np.nan), np.zeros((50, 2)))
    with pytest.raises(ValueError, match="at least 8"):
        fit(np.zeros((0, 3)), np.zeros((0, 2)))


@each_method
@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("poses", np.zeros((20, 2))),
        ("poses", np.cumsum(np.ones((20, 3)), axis=0) * 1e120),
        ("u", np.zeros((19, 2))),
        ("u", np.full((20, 2), np.nan)),
        ("breaks", np.zeros(20)),
        ("breaks", np.zeros(3, dtype=bool)),
    ],
)
def test_records_that_do_not_fit_together_are_named(fit, name, wrong):
    good = {"poses": np.zeros((20, 3)), "u": np.zeros((20, 2)), "breaks": None}
    with pytest.raises(ValueError, match=rf"\b{name}\b"):
        fit(**good | {name: wrong})


@given(rows=st.integers(0, 6), others=st.integers(0, 6))
def test_a_regression_has_as_many_inputs_as_poses(rows, others):
    poses, u = np.zeros((rows, 3)), np.zeros((others, 2))
    if rows == others:
        phi, y = robsim.estimation.regression(poses, u)
        assert phi.shape == (max(rows - 2, 0), 3, 5)
        assert y.shape == (max(rows - 2, 0), 3)
    else:
        with pytest.raises(ValueError, match=r"\bu\b"):
            robsim.estimation.regression(poses, u)


@each_method
def test_the_arguments_stay_as_they_are(fit):
    path, u, noise = drive(1, steps=100)
    poses = wrapped(path + noise)
    poses[20, 0] = np.nan
    before = poses.copy(), u.copy()
    fit(poses, u)
    np.testing.assert_array_equal(poses, before[0])
    np.testing.assert_array_equal(u, before[1])
