from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra import numpy as npst

import robsim
from sizes import thorough

pytestmark = pytest.mark.kernels


def drawn(rng, samples, parameters=5):
    phi = rng.normal(size=(samples, parameters))
    theta = rng.normal(size=parameters)
    return phi, phi @ theta + 0.1 * rng.normal(size=samples)


def ridge(phi, y, weights, prior):
    """The solution of all samples at once, weighted, with the prior's share."""
    information = (phi * weights[:, None]).T @ phi + prior * np.eye(phi.shape[1])
    return np.linalg.solve(information, phi.T @ (weights * y)), np.linalg.inv(information)


def exact_ridge(phi, y, prior):
    """The same without forgetting, in rational numbers: no rounding at all."""
    phi = [[Fraction(x) for x in row] for row in phi.tolist()]
    y = [Fraction(x) for x in y.tolist()]
    n = len(phi[0])
    rows = [
        [sum(row[i] * row[j] for row in phi) + (i == j) * Fraction(prior) for j in range(n)]
        + [sum(row[i] * output for row, output in zip(phi, y, strict=True))]
        for i in range(n)
    ]
    for i in range(n):  # Gauss and Jordan
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for k in set(range(n)) - {i}:
            rows[k] = [x - rows[k][i] * z for x, z in zip(rows[k], rows[i], strict=True)]
    return np.array([float(row[n]) for row in rows])


@pytest.mark.long
def test_on_a_drive_it_equals_the_ridge_solution_to_the_last_digits(rng):
    run = robsim.Simulation(control=robsim.DriveAround(), boundary="unlimited", seed=4).run(200)
    phi, y = robsim.estimation.regression(run.pose_true, run.u)
    y = y + (0.1, 0.1, 0.005) * rng.normal(size=y.shape)
    theta = robsim.RecursiveLeastSquares(5, n_filters=3, initial_covariance=2.0**20).update(phi, y)
    for axis in range(3):
        exact = exact_ridge(phi[:, axis], y[:, axis], 2.0**-20)
        assert np.linalg.norm(theta[-1, axis] - exact) < 1e-12 * np.linalg.norm(exact)


@pytest.mark.parametrize("forgetting", [1.0, 0.99, 0.9])
def test_it_equals_the_weighted_ridge_solution(rng, forgetting):
    phi, y = drawn(rng, 200)
    filter_ = robsim.RecursiveLeastSquares(5, forgetting=forgetting, initial_covariance=100.0)
    for row, output in zip(phi, y, strict=True):
        estimate = filter_.update(row, output)
    weights = forgetting ** np.arange(199, -1, -1)
    theta, P = ridge(phi, y, weights, forgetting**200 / 100)
    np.testing.assert_allclose(estimate, theta, rtol=1e-9)
    np.testing.assert_allclose(filter_.P, P, rtol=1e-9, atol=1e-15)


def test_filters_side_by_side_do_not_see_each_other(rng):
    phi, y = zip(*(drawn(rng, 50, 4) for _ in range(3)), strict=True)
    together = robsim.RecursiveLeastSquares(4, n_filters=3)
    alone = [robsim.RecursiveLeastSquares(4) for _ in range(3)]
    for k in range(50):
        theta = together.update([p[k] for p in phi], [o[k] for o in y])
        for i in range(3):
            np.testing.assert_array_equal(theta[i], alone[i].update(phi[i][k], y[i][k]))


@pytest.mark.long
@pytest.mark.parametrize("forgetting", [0.999, 0.95])
def test_the_covariance_stays_symmetric_and_positive_where_the_common_form_diverges(
    rng, forgetting
):
    filter_ = robsim.RecursiveLeastSquares(3, forgetting=forgetting)
    phi = rng.normal(size=(30_000, 3))
    estimate = filter_.update(phi, phi @ (1.0, -2.0, 0.5))[-1]
    np.testing.assert_array_equal(filter_.P, filter_.P.T)
    assert np.linalg.eigvalsh(filter_.P).min() > 0
    np.testing.assert_allclose(estimate, (1.0, -2.0, 0.5), rtol=1e-9)


def test_bad_samples_change_nothing():
    filter_ = robsim.RecursiveLeastSquares(2, forgetting=0.9)
    filter_.update([1.0, 2.0], 3.0)
    before = filter_.theta.copy(), filter_.P.copy()
    for phi, y, name in (
        ([1], 1, "phi"),
        ([1, 2, 3], 1, "phi"),
        ([[[1, 2]]], 1, "phi"),
        ([np.inf, 1], 1, "phi"),
        ([1e200, 1e200], 1, "phi"),
        ([1, 2], [1], "y"),
        ([1, 2], np.inf, "y"),
        ([[1, 2]], 1, "y"),
        ([[1, 2]], [1, 2], "y"),
        ([[1, 2]], [[1]], "y"),
        ([[1.0, 2.0], [1.0, np.inf]], [1.0, 2.0], "1e50"),
    ):
        with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
            filter_.update(phi, y)
    np.testing.assert_array_equal(filter_.theta, before[0])
    np.testing.assert_array_equal(filter_.P, before[1])
    assert filter_.n_samples == 1


@settings(max_examples=60)
@given(
    phi=npst.array_shapes(min_dims=0, max_dims=4, max_side=4),
    y=npst.array_shapes(min_dims=0, max_dims=2, max_side=4),
)
def test_update_of_three_filters(phi, y):
    filters = robsim.RecursiveLeastSquares(2, n_filters=3)
    fits = phi[-2:] == (3, 2) and len(phi) <= 3
    if fits and y == phi[:-1]:
        assert filters.update(np.ones(phi), np.ones(y)).shape == phi
    else:
        name = "y" if fits else "phi"
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            filters.update(np.ones(phi), np.ones(y))
        np.testing.assert_array_equal(filters.theta, np.zeros((3, 2)))


@pytest.mark.parametrize(("parameters", "filters"), [(1, 1), (5, 3), (7, 6)])
def test_rows_of_samples_are_the_same_as_single_ones(rng, parameters, filters):
    shape = (40, filters, parameters) if filters > 1 else (40, parameters)
    phi, y = rng.normal(size=shape), rng.normal(size=shape[:-1])
    phi[11, ..., 0] = np.nan
    options = {"n_filters": filters, "forgetting": 0.9}
    together = robsim.RecursiveLeastSquares(parameters, **options)
    one_by_one = robsim.RecursiveLeastSquares(parameters, **options)
    history = together.update(phi, y)
    for k in range(40):
        np.testing.assert_array_equal(history[k], one_by_one.update(phi[k], y[k]))
    np.testing.assert_array_equal(together.P, one_by_one.P)
    assert together.update(phi[:0], y[:0]).shape == (0, *shape[1:])


def test_a_filter_without_a_sample_holds_and_the_others_go_on(rng):
    phi, y = rng.normal(size=(30, 3, 5)), rng.normal(size=(30, 3))
    phi[10:20, 1, 2] = np.nan
    y[25, 2] = np.nan
    filters = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.9)
    history = filters.update(phi, y)
    np.testing.assert_array_equal(history[9:20, 1], np.tile(history[9, 1], (11, 1)))
    np.testing.assert_array_equal(history[25, 2], history[24, 2])
    np.testing.assert_array_equal(filters.n_samples, [30, 20, 29])
    # As if there had been no such samples at all.
    for i, seen in enumerate(
        [range(30), [*range(10), *range(20, 30)], [*range(25), *range(26, 30)]]
    ):
        alone = robsim.RecursiveLeastSquares(5, forgetting=0.9)
        for k in seen:
            alone.update(phi[k, i], y[k, i])
        np.testing.assert_array_equal(filters.theta[i], alone.theta)
        np.testing.assert_array_equal(filters.P[i], alone.P)


def test_unit_errors_are_the_roots_of_the_diagonal(rng):
    filters = robsim.RecursiveLeastSquares(4, n_filters=2, forgetting=0.95)
    filters.update(rng.normal(size=(20, 2, 4)), rng.normal(size=(20, 2)))
    diagonals = np.diagonal(filters.P, axis1=1, axis2=2)
    np.testing.assert_allclose(filters.standard_errors_unscaled, np.sqrt(diagonals), rtol=1e-13)


def test_reset_goes_back_to_the_start():
    filter_ = robsim.RecursiveLeastSquares(2, initial_covariance=10.0)
    filter_.update([1.0, 2.0], 3.0)
    filter_.reset()
    np.testing.assert_array_equal(filter_.theta, [0, 0])
    np.testing.assert_array_equal(filter_.P, 10 * np.eye(2))


def test_options_out_of_range_are_refused():
    robsim.RecursiveLeastSquares(1000, initial_covariance=1e50, forgetting=1)
    for name, values in (
        ("n_parameters", (0, -1, 1001, 1.5)),
        ("n_filters", (0, -1, 100_001, 2**31)),
        ("forgetting", (0, -0.0, -1, 1.000001, np.inf)),
        ("initial_covariance", (0, -1, 1.1e50, np.inf)),
    ):
        for value in values:
            with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                robsim.RecursiveLeastSquares(**{"n_parameters": 2} | {name: value})
    with pytest.raises(ValueError, match=r"n_filters.*101000000"):
        robsim.RecursiveLeastSquares(1000, n_filters=101)


LIMIT = 1e9  # of the covariance, for each parameter


@pytest.mark.long
@pytest.mark.parametrize("forgetting", [1.0, 0.99, 0.95])
@pytest.mark.parametrize("excitation", ["rich", "poor", "none"])
def test_after_very_many_updates_it_is_still_right(rng, forgetting, excitation):
    theta = np.array([1.9, -0.9, 0.2, 0.2, 0.01])
    filter_ = robsim.RecursiveLeastSquares(5, forgetting=forgetting)
    scale = {"rich": (1, 1, 1, 1, 1), "poor": (1, 1e-6, 1, 0, 0), "none": (0, 0, 0, 0, 0)}
    base = np.array((0.0, 1.0, 0.0, 1.0, 1.0))
    # Where it forgets, 50 000 updates are 500 times its memory, 1/(1 - forgetting), or more.
    for _ in range(thorough(10, 4) if forgetting == 1 else 2):
        phi = base + rng.normal(size=(thorough(100_000, 25_000), 5)) * scale[excitation]
        estimate = filter_.update(phi, phi @ theta)[-1]
        P = filter_.P
        assert np.isfinite(estimate).all()
        np.testing.assert_array_equal(P, P.T)
        assert np.trace(P) <= 5 * LIMIT * (1 + 1e-9)
        np.linalg.cholesky(P / np.sqrt(np.outer(P.diagonal(), P.diagonal())) + 1e-9 * np.eye(5))
        assert phi[-1] @ estimate == pytest.approx(phi[-1] @ theta, abs=1e-6)
    if excitation == "rich":
        np.testing.assert_allclose(estimate, theta, atol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("forgetting", [0.99, 0.5])
@pytest.mark.parametrize("constant", [(600.0, 599.0, 0.5, 0.7, 1.0), (1.0, 1.0, 1.0, 1.0, 1.0)])
def test_after_a_long_constant_input_a_change_is_followed_as_by_a_new_filter(
    rng, forgetting, constant
):
    before = np.array([1.9, -0.9, 0.2, 0.2, 0.1])
    after = np.array([1.5, -0.5, 0.4, 0.1, 0.3])
    used = robsim.RecursiveLeastSquares(5, forgetting=forgetting)
    phi = np.tile(constant, (thorough(100_000, 30_000), 1))
    held = used.update(phi, phi @ before + 0.1 * rng.normal(size=len(phi)))
    assert np.abs(held).max() < 10
    assert np.trace(used.P) <= 5 * LIMIT * (1 + 1e-9)
    new = robsim.RecursiveLeastSquares(5, forgetting=forgetting)
    samples = int(5 / (1 - forgetting)) + 10
    phi = rng.normal(size=(samples, 5)) * (300, 300, 1, 1, 1)
    y = phi @ after + 0.1 * rng.normal(size=samples)
    # What the samples before told is forgotten: the estimates come together.
    difference = np.abs(used.update(phi, y) - new.update(phi, y)).max(axis=1)
    assert difference[-1] < 0.05 * np.abs(after - before).max()
    assert np.abs(used.theta - after).max() < np.abs(new.theta - after).max() + 0.02


def test_forgetting_without_excitation_stays_finite():
    filter_ = robsim.RecursiveLeastSquares(2, forgetting=0.5)
    filter_.update(np.tile([1.0, 0.0], (5000, 1)), np.full(5000, 2.0))
    np.testing.assert_allclose(filter_.P, [[0.5, 0], [0, 2 * LIMIT / 2]], rtol=1e-12)
    assert filter_.theta[0] == pytest.approx(2.0)
    assert filter_.theta[1] == 0


@pytest.mark.parametrize("forgetting", [1, 0.5, 1e-10])
def test_stays_finite_for_all_that_it_takes(rng, forgetting):
    """Regressors of any size beside each other, exact fits, any first covariance."""
    sizes = [0, 1e-300, 1e-50, 1, 1e8, 1e50]
    for covariance in (1e-300, 1, 1e9, 1e50):
        filters = robsim.RecursiveLeastSquares(
            5, n_filters=30, forgetting=forgetting, initial_covariance=covariance
        )
        for _ in range(40):
            signs = rng.choice([-1, 0, 1], (30, 5))
            filters.update(signs * rng.choice(sizes, (30, 5)), rng.choice(sizes, 30))
        assert np.isfinite(filters.theta).all()
        assert np.isfinite(filters.P).all()
