import numpy as np
import pytest

import robsim


def drawn(rng, samples, parameters=5):
    phi = rng.normal(size=(samples, parameters))
    theta = rng.normal(size=parameters)
    return phi, phi @ theta + 0.1 * rng.normal(size=samples)


def ridge(phi, y, weights, prior):
    """The solution of all samples at once, weighted, with the prior's share."""
    information = (phi * weights[:, None]).T @ phi + prior * np.eye(phi.shape[1])
    return np.linalg.solve(information, phi.T @ (weights * y)), np.linalg.inv(information)


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
    together = robsim.RecursiveLeastSquares(4, filters=3)
    alone = [robsim.RecursiveLeastSquares(4) for _ in range(3)]
    for k in range(50):
        theta = together.update([p[k] for p in phi], [o[k] for o in y])
        for i in range(3):
            np.testing.assert_array_equal(theta[i], alone[i].update(phi[i][k], y[i][k]))


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
    for phi, y in [
        ([1, 2], 3),
        ([1, 2, np.nan], 3),
        ([1, 2, 3], np.inf),
        (None, 1),
        ([1, 2, 3], "x"),
    ]:
        with pytest.raises((TypeError, ValueError), match=r"phi|y"):
            filter_.update(phi, y)
    np.testing.assert_array_equal(filter_.theta, before[0])
    np.testing.assert_array_equal(filter_.P, before[1])


def test_reset_goes_back_to_the_start():
    filter_ = robsim.RecursiveLeastSquares(2, initial_covariance=10.0)
    filter_.update([1.0, 2.0], 3.0)
    filter_.reset()
    np.testing.assert_array_equal(filter_.theta, [0, 0])
    np.testing.assert_array_equal(filter_.P, 10 * np.eye(2))


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"parameters": 0}, "parameters"),
        ({"parameters": 2, "filters": 0}, "filters"),
        ({"parameters": 2, "forgetting": 0.0}, "forgetting"),
        ({"parameters": 2, "forgetting": 1.1}, "forgetting"),
        ({"parameters": 2, "initial_covariance": 0.0}, "initial_covariance"),
    ],
)
def test_options_out_of_range_are_refused(options, name):
    with pytest.raises(ValueError, match=name):
        robsim.RecursiveLeastSquares(**options)


def test_forgetting_without_excitation_stays_finite():
    filter_ = robsim.RecursiveLeastSquares(2, forgetting=0.5)
    for _ in range(5000):
        filter_.update([1.0, 0.0], 2.0)
    assert np.isfinite(filter_.P).all()
    assert filter_.theta[0] == pytest.approx(2.0)
