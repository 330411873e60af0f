import numpy as np
import pytest

import robsim


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [
        (0.0, 0.0),
        (np.pi, np.pi),
        (-np.pi, np.pi),
        (3 * np.pi, np.pi),
        (np.pi + 0.25, -np.pi + 0.25),
        (-1.5, -1.5),
    ],
)
def test_wrap_angle_of_single_values(angle, wrapped):
    assert robsim.wrap_angle(angle) == pytest.approx(wrapped, abs=1e-12)


def test_wrapped_angles_lie_in_the_half_open_range_and_differ_by_full_turns(rng):
    angles = rng.uniform(-100, 100, 10_000)
    wrapped = robsim.wrap_angle(angles)
    assert (wrapped > -np.pi).all()
    assert (wrapped <= np.pi).all()
    turns = (angles - wrapped) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-12)
