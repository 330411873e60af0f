"""What is no filter and no sample is refused in its name, and changes nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra import numpy as npst

from refusals import INF, NAN, NO_COUNT, Refusal, options, refusals, refuses
from robsim import RecursiveLeastSquares
from robsim.identification import least_squares


@refusals(
    options(
        RecursiveLeastSquares,
        {
            "n_parameters n_filters": (0, *NO_COUNT),
            "forgetting": (0, -0.0, -1, 1.000001, NAN, INF, None, "1"),
            "initial_covariance": (0, -1, NAN, INF, None, "1"),
        },
        n_parameters=5,
    ),
    options(RecursiveLeastSquares, {"lambda_": (1,)}, 5),
    Refusal(RecursiveLeastSquares, "n_parameters", (0,), says="got 0$"),
    Refusal(
        lambda value: least_squares(value, [1, 2]),
        "phi",
        (
            *(None, 5, "ab", [1, 2], np.ones((1, 2, 2)), [["a"] * 2] * 2, np.ones((2, 0))),
            *(np.eye(2) * NAN, np.full((2, 2), INF), np.eye(2) * 1e200),
        ),
    ),
    Refusal(lambda value: least_squares(value, []), "phi", (np.ones((0, 2)),)),
    Refusal(
        lambda value: least_squares(np.eye(2), value),
        "y",
        (None, 5, "ab", [1], [1, 2, 3], [[1], [2]], [NAN, 1], [1e200, 0]),
    ),
)
def test_filters_and_samples(refusal):
    refusal()


NO_SAMPLES = [
    *((v, 1, "phi") for v in (None, 5, "ab", [1], [1, 2, 3], [[1, 2, 3]], [INF, 1])),
    *((v, 1, "phi") for v in (["a", "b"], [None, 1], [1j, 1], [[[1, 2]]])),
    *(([1, 2], v, "y") for v in (None, "1", [1], [1, 2], INF, 1j)),
    *(([[1, 2]], v, "y") for v in (1, [1, 2], [[1]], [INF], [None])),
    ([1, 2], 10**400, "y"),
]


@pytest.mark.parametrize(("phi", "y", "name"), NO_SAMPLES)
def test_update_of_one_filter_changes_nothing(phi, y, name):
    filters = RecursiveLeastSquares(2, forgetting=0.9)
    filters.update([1, 2], 3)
    theta, P = filters.theta, filters.P
    refuses(name, filters.update, phi, y)
    np.testing.assert_array_equal(filters.theta, theta)
    np.testing.assert_array_equal(filters.P, P)


@settings(max_examples=60)
@given(
    phi=npst.array_shapes(min_dims=0, max_dims=4, max_side=4),
    y=npst.array_shapes(min_dims=0, max_dims=2, max_side=4),
)
def test_update_of_three_filters(phi, y):
    filters = RecursiveLeastSquares(2, n_filters=3)
    fits = phi[-2:] == (3, 2) and len(phi) <= 3
    if fits and y == phi[:-1]:
        assert filters.update(np.ones(phi), np.ones(y)).shape == phi
    else:
        name = "y" if fits else "phi"
        refuses(name, filters.update, np.ones(phi), np.ones(y))
        np.testing.assert_array_equal(filters.theta, np.zeros((3, 2)))


@pytest.mark.parametrize("phi", [(1e200, 1e200), (1e308, 0)])
def test_a_sample_that_overflows_changes_nothing(phi):
    filters = RecursiveLeastSquares(2)
    with pytest.raises((ValueError, OverflowError)):
        filters.update(phi, 1)
    assert np.isfinite(filters.theta).all()


def test_least_squares_of_large_numbers():
    fit = least_squares(np.eye(2) * 1e100, [1e100, 1e99])
    np.testing.assert_allclose(fit.theta, [1, 0.1])
