"""Least squares, and the rule of full rank."""

import numpy as np
import pytest

from robsim.estimation import cramer_rao_bound, least_squares

pytestmark = pytest.mark.kernels


# --- least squares


def test_it_equals_numpy_on_badly_scaled_columns(rng):
    scale = np.array((1, 30, 0.02, 100, 1))
    phi = rng.normal(size=(300, 5)) * scale
    y = rng.normal(size=300)
    fit = least_squares(phi, y)
    theta = np.linalg.lstsq(phi, y, rcond=None)[0]
    # a parameter may be 0 by chance: each is as exact as its column lets it be
    error = np.linalg.norm((fit.theta - theta) * scale)
    assert error < 1e-11 * np.linalg.norm(theta * scale)
    assert fit.rank == 5
    assert 1 <= fit.condition < 2
    assert fit.residual_rms == pytest.approx(np.sqrt(np.mean((y - phi @ theta) ** 2)), rel=1e-12)


def test_what_the_samples_do_not_determine_is_nan(rng):
    phi = rng.normal(size=(50, 4))
    phi[:, 3] = 2 * phi[:, 1]
    theta = np.array([1.0, 2.0, 3.0, 0.5])
    fit = least_squares(phi, phi @ theta)
    assert fit.rank == 3
    np.testing.assert_array_equal(np.isnan(fit.theta), [False, True, False, True])
    np.testing.assert_allclose(fit.theta[[0, 2]], [1.0, 3.0], rtol=1e-10)


def test_fewer_samples_than_parameters():
    fit = least_squares([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]], [3.0, 4.0])
    assert fit.rank == 2
    assert fit.condition == np.inf
    np.testing.assert_array_equal(fit.theta, [3.0, np.nan, np.nan])


def test_bad_samples_are_refused():
    for phi, y, name in (
        (np.empty((0, 3)), np.empty(0), "phi"),
        (np.ones((2, 0)), np.ones(2), "phi"),
        (np.full((4, 2), np.nan), np.ones(4), "phi"),
        (np.eye(2) * 1e200, np.ones(2), "phi"),
        (np.ones(4), np.ones(4), "phi"),
        (np.ones((4, 2)), np.ones(3), "y"),
        (np.ones((4, 2)), [1, 2, 3, np.inf], "y"),
        (np.eye(2), [1e200, 0], "y"),
        (np.eye(2), [[1], [2]], "y"),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            least_squares(phi, y)
    fit = least_squares(np.eye(2) * 1e100, [1e100, 1e99])
    np.testing.assert_allclose(fit.theta, [1, 0.1])


def normal_equations(phi, y):
    """Standard errors as in a textbook."""
    theta = np.linalg.solve(phi.T @ phi, phi.T @ y)
    variance = np.sum((y - phi @ theta) ** 2) / (len(y) - phi.shape[1])
    unit = np.sqrt(np.diagonal(np.linalg.inv(phi.T @ phi)))
    return unit, np.sqrt(variance) * unit


@pytest.mark.parametrize("samples", [6, 255, 256, 257])
def test_standard_errors_are_those_of_the_normal_equations(rng, samples):
    phi = rng.normal(size=(samples, 4)) * (1, 20, 0.1, 3)
    y = phi @ (1.0, 2.0, 3.0, 4.0) + rng.normal(size=samples)
    fit = least_squares(phi, y)
    unit, errors = normal_equations(phi, y)
    np.testing.assert_allclose(fit.standard_errors_unscaled, unit, rtol=1e-10)
    np.testing.assert_allclose(fit.standard_errors, errors, rtol=1e-10)
    theta, squares, _, _ = np.linalg.lstsq(phi, y, rcond=None)
    np.testing.assert_allclose(fit.theta, theta, rtol=1e-10)
    assert fit.residual_rms == pytest.approx(np.sqrt(squares[0] / samples), rel=1e-10)


def test_standard_errors_of_what_is_determined_do_not_feel_the_rest(rng):
    full = rng.normal(size=(50, 3))
    y = full @ (1.0, 2.0, 3.0) + 0.1 * rng.normal(size=50)
    phi = np.column_stack([full, 2 * full[:, 1], np.zeros(50)])
    fit = least_squares(phi, y)
    unit, errors = normal_equations(full, y)
    np.testing.assert_allclose(fit.standard_errors_unscaled[[0, 2]], unit[[0, 2]], rtol=1e-10)
    np.testing.assert_allclose(fit.standard_errors[[0, 2]], errors[[0, 2]], rtol=1e-10)
    assert np.isinf(fit.standard_errors[[1, 3, 4]]).all()
    assert np.isinf(fit.standard_errors_unscaled[[1, 3, 4]]).all()
    assert fit.residual_rms == pytest.approx(least_squares(full, y).residual_rms, rel=1e-10)


def test_as_many_samples_as_parameters_say_nothing_of_the_noise(rng):
    fit = least_squares(rng.normal(size=(3, 3)), rng.normal(size=3))
    assert np.isnan(fit.standard_errors).all()
    assert np.isfinite(fit.standard_errors_unscaled).all()
    assert fit.residual_rms < 1e-12


# --- full rank


TOLERANCE = 1e-10  # relative, of the singular values
SCALE = np.array([1e-4, 1e3, 1e5])


def least_squares_errors(phi):
    return least_squares(phi, np.ones(len(phi))).standard_errors_unscaled


def bounds(phi):
    return cramer_rao_bound(phi, 1.0)[-1]


each = pytest.mark.parametrize("errors", [least_squares_errors, bounds])


def almost_dependent(ratio, rng):
    """Two columns whose smaller singular value is this fraction of the larger, and a third one."""
    a, b, c = np.linalg.qr(rng.normal(size=(50, 3)))[0].T
    return np.column_stack([a + ratio * b, a - ratio * b, c]) * SCALE


@each
def test_what_lies_above_the_tolerance_is_determined(errors, rng):
    # The first two unknowns are (a' y + b' y / r)/2 and (a' y - b' y / r)/2.
    ratio = 10 * TOLERANCE
    expected = np.array([0.5 / ratio, 0.5 / ratio, 1]) / SCALE
    np.testing.assert_allclose(errors(almost_dependent(ratio, rng)), expected, rtol=1e-3)


@each
@pytest.mark.parametrize("ratio", [0.1 * TOLERANCE, 0])
def test_what_lies_below_the_tolerance_is_not(errors, ratio, rng):
    found = errors(almost_dependent(ratio, rng))
    assert np.isinf(found[:2]).all()
    assert found[2] == pytest.approx(1 / SCALE[2])


@each
def test_a_column_of_zeros_is_not_determined_and_disturbs_no_other(errors, rng):
    phi = np.column_stack([np.linalg.qr(rng.normal(size=(50, 2)))[0], np.zeros(50)])
    np.testing.assert_allclose(errors(phi), [1, 1, np.inf])


@each
def test_fewer_samples_than_unknowns_determine_none(errors, rng):
    assert np.isinf(errors(rng.normal(size=(2, 3)))).all()
