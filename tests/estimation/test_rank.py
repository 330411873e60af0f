"""What full rank is: one rule for least squares and the bounds."""

import numpy as np
import pytest

from robsim.estimation import cramer_rao_bound, least_squares

pytestmark = pytest.mark.kernels

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
