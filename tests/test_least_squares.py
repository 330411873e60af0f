import numpy as np
import pytest

import robsim


def test_it_equals_numpy_on_badly_scaled_columns(rng):
    phi = rng.normal(size=(300, 5)) * (1, 30, 0.02, 100, 1)
    y = rng.normal(size=300)
    fit = robsim.least_squares(phi, y)
    theta = np.linalg.lstsq(phi, y, rcond=None)[0]
    np.testing.assert_allclose(fit.theta, theta, rtol=1e-10)
    assert fit.rank == 5
    assert 1 <= fit.condition < 2
    assert fit.residual_rms == pytest.approx(np.sqrt(np.mean((y - phi @ theta) ** 2)), rel=1e-12)


def test_what_the_samples_do_not_determine_is_nan(rng):
    phi = rng.normal(size=(50, 4))
    phi[:, 3] = 2 * phi[:, 1]
    theta = np.array([1.0, 2.0, 3.0, 0.5])
    fit = robsim.least_squares(phi, phi @ theta)
    assert fit.rank == 3
    np.testing.assert_array_equal(np.isnan(fit.theta), [False, True, False, True])
    np.testing.assert_allclose(fit.theta[[0, 2]], [1.0, 3.0], rtol=1e-10)


def test_fewer_samples_than_parameters():
    fit = robsim.least_squares([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]], [3.0, 4.0])
    assert fit.rank == 2
    assert fit.condition == np.inf
    np.testing.assert_array_equal(fit.theta, [3.0, np.nan, np.nan])


@pytest.mark.parametrize(
    ("phi", "y", "name"),
    [
        (np.empty((0, 3)), np.empty(0), "phi"),
        (np.ones((4, 2)), np.ones(3), "y"),
        (np.full((4, 2), np.nan), np.ones(4), "phi"),
        (np.ones(4), np.ones(4), "phi"),
        (np.ones((4, 2)), [1, 2, 3, np.inf], "y"),
    ],
)
def test_bad_samples_are_refused(phi, y, name):
    with pytest.raises(ValueError, match=name):
        robsim.least_squares(phi, y)
