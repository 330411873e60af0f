from fractions import Fraction

import numpy as np
import pytest

import robsim
from robsim import _core

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


@pytest.mark.parametrize("initial_covariance", [1.0, 2.0**30])
def test_without_forgetting_it_equals_the_ridge_solution_to_the_last_digits(
    rng, initial_covariance
):
    phi, y = drawn(rng, 150)
    filter_ = robsim.RecursiveLeastSquares(5, initial_covariance=initial_covariance)
    theta = exact_ridge(phi, y, 1 / initial_covariance)
    np.testing.assert_allclose(filter_.update(phi, y)[-1], theta, rtol=1e-12)


@pytest.mark.long
def test_on_a_drive_it_equals_the_ridge_solution_to_the_last_digits(rng):
    run = robsim.Simulation(control=robsim.DriveAround(), boundary="unlimited", seed=4).run(200)
    phi, y = _core.regression(run.pose_true, run.u)
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
@pytest.mark.parametrize("forgetting", [0.999, 0.99, 0.95])
def test_the_covariance_stays_symmetric_and_positive_where_the_common_form_diverges(
    rng, forgetting
):
    filter_ = robsim.RecursiveLeastSquares(3, forgetting=forgetting)
    for row in rng.normal(size=(30_000, 3)):
        estimate = filter_.update(row, row @ (1.0, -2.0, 0.5))
    np.testing.assert_array_equal(filter_.P, filter_.P.T)
    assert np.linalg.eigvalsh(filter_.P).min() > 0
    np.testing.assert_allclose(estimate, (1.0, -2.0, 0.5), rtol=1e-9)


def test_bad_samples_change_nothing(rng):
    filter_ = robsim.RecursiveLeastSquares(3)
    filter_.update([1.0, 2.0, 3.0], 4.0)
    before = filter_.theta.copy(), filter_.P.copy()
    for phi, y in [([1, 2], 3), ([1, 2, 3], np.inf), (None, 1), ([1, 2, 3], "x")]:
        with pytest.raises((TypeError, ValueError), match=r"phi|y"):
            filter_.update(phi, y)
    np.testing.assert_array_equal(filter_.theta, before[0])
    np.testing.assert_array_equal(filter_.P, before[1])


def test_one_bad_sample_among_many_changes_nothing():
    filter_ = robsim.RecursiveLeastSquares(2)
    with pytest.raises(ValueError, match="at most 1e50"):
        filter_.update([[1.0, 2.0], [1.0, np.inf]], [1.0, 2.0])
    assert filter_.n_samples == 0
    np.testing.assert_array_equal(filter_.theta, [0, 0])


@pytest.mark.parametrize("parameters", [1, 3, 5, 7])
@pytest.mark.parametrize("filters", [1, 3, 6])
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


def test_every_processor_gives_the_same_bits(rng):
    phi, y = rng.normal(size=(200, 3, 5)), rng.normal(size=(200, 3))
    results = []
    used = _core.cpu_path()
    try:
        for path in _core.cpu_paths():
            _core.force_cpu_path(path)
            filters = robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.98)
            results.append((filters.update(phi, y), filters.P))
    finally:
        _core.force_cpu_path(used)
    for history, P in results[1:]:
        np.testing.assert_array_equal(history, results[0][0])
        np.testing.assert_array_equal(P, results[0][1])


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


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"n_parameters": 0}, "n_parameters"),
        ({"n_parameters": 2, "n_filters": 0}, "n_filters"),
        ({"n_parameters": 2, "forgetting": 0.0}, "forgetting"),
        ({"n_parameters": 2, "forgetting": 1.1}, "forgetting"),
        ({"n_parameters": 2, "initial_covariance": 0.0}, "initial_covariance"),
    ],
)
def test_options_out_of_range_are_refused(options, name):
    with pytest.raises(ValueError, match=name):
        robsim.RecursiveLeastSquares(**options)


@pytest.mark.parametrize("value", [5e-324, 1e300, -0.1])
def test_what_came_is_told_in_digits_that_count(value):
    with pytest.raises(ValueError, match="forgetting") as caught:
        robsim.RecursiveLeastSquares(2, initial_covariance=1.0, forgetting=value)
    assert float(str(caught.value).rpartition("got ")[2]) == pytest.approx(value, rel=1e-9, abs=0)


LIMIT = 1e9  # of the covariance, for each parameter


@pytest.mark.long
@pytest.mark.parametrize("forgetting", [1.0, 0.999, 0.99, 0.95])
@pytest.mark.parametrize("excitation", ["rich", "poor", "none"])
def test_after_very_many_updates_it_is_still_right(rng, forgetting, excitation):
    theta = np.array([1.9, -0.9, 0.2, 0.2, 0.01])
    filter_ = robsim.RecursiveLeastSquares(5, forgetting=forgetting)
    scale = {"rich": (1, 1, 1, 1, 1), "poor": (1, 1e-6, 1, 0, 0), "none": (0, 0, 0, 0, 0)}
    base = np.array((0.0, 1.0, 0.0, 1.0, 1.0))
    # Where it forgets, 200 000 updates are 200 times its memory, 1/(1 - forgetting), or more.
    for _ in range(10 if forgetting == 1 else 2):
        phi = base + rng.normal(size=(100_000, 5)) * scale[excitation]
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
@pytest.mark.parametrize("forgetting", [0.999, 0.99, 0.95, 0.5])
@pytest.mark.parametrize("constant", [(600.0, 599.0, 0.5, 0.7, 1.0), (1.0, 1.0, 1.0, 1.0, 1.0)])
def test_after_a_long_constant_input_a_change_is_followed_as_by_a_new_filter(
    rng, forgetting, constant
):
    before = np.array([1.9, -0.9, 0.2, 0.2, 0.1])
    after = np.array([1.5, -0.5, 0.4, 0.1, 0.3])
    used = robsim.RecursiveLeastSquares(5, forgetting=forgetting)
    phi = np.tile(constant, (100_000, 1))
    held = used.update(phi, phi @ before + 0.1 * rng.normal(size=100_000))
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


@pytest.mark.parametrize(
    ("parameters", "filters", "message"),
    [
        (1001, 1, r"n_parameters must lie within 1\.\.1000, got 1001"),
        (2, 100_001, r"n_filters must lie within 1\.\.100000, got 100001"),
        (1000, 101, r"n_filters \* n_parameters\^2 must be at most 1e8, got 101000000"),
    ],
)
def test_filters_that_no_memory_holds(parameters, filters, message):
    with pytest.raises(ValueError, match=message):
        robsim.RecursiveLeastSquares(parameters, n_filters=filters)


@pytest.mark.parametrize("forgetting", [1, 0.99, 0.5, 1e-10])
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


@pytest.mark.parametrize("covariance", [1.1e50, 1e300, 0, -1, np.inf, np.nan])
def test_a_first_covariance_that_would_overflow(covariance):
    with pytest.raises(ValueError, match="initial_covariance must be above 0 and at most 1e50"):
        robsim.RecursiveLeastSquares(5, initial_covariance=covariance)
