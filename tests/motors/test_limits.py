"""What the motors are asked for at most."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robsim.lab import Limits

volts = st.floats(-20, 20)
inputs = st.tuples(volts, volts)
limits = st.floats(0.01, 30)


@given(inputs, limits)
def test_a_voltage_limit_keeps_the_curve(u, limit):
    result = Limits(voltage=limit).applied(u, (0, 0), 0.1)
    assert np.abs(result).max() <= limit
    if np.abs(u).max() <= limit:
        assert result.tolist() == list(u)
    else:
        assert np.abs(result).max() == pytest.approx(limit)
        assert result[0] * u[1] == pytest.approx(result[1] * u[0], abs=1e-9)
        assert (result * u >= 0).all()


@given(inputs, inputs, limits, st.floats(0, 2))
def test_a_slew_rate_limits_the_change_and_keeps_its_direction(u, before, limit, dt):
    result = Limits(slew_rate=limit).applied(u, before, dt)
    change, wanted = result - before, np.subtract(u, before)
    if u == (0, 0):
        assert result.tolist() == [0, 0]
        return
    assert np.abs(change).max() <= limit * dt + 1e-12
    assert change[0] * wanted[1] == pytest.approx(change[1] * wanted[0], abs=1e-9)
    if np.abs(wanted).max() <= limit * dt:
        assert result.tolist() == list(u)


@given(inputs, limits, limits, st.floats(0.01, 2))
def test_both_limits_hold_on_the_way_to_any_input(u, voltage, slew_rate, dt):
    both = Limits(voltage=voltage, slew_rate=slew_rate)
    before = np.zeros(2)
    for _ in range(20):
        after = both.applied(u, before, dt)
        assert np.abs(after).max() <= voltage
        assert np.abs(after - before).max() <= slew_rate * dt + 1e-12
        before = after


def test_stopping_is_never_slowed_down():
    assert Limits(voltage=1, slew_rate=0.01).applied((0, 0), (9, -9), 0.0).tolist() == [0, 0]


def test_what_is_out_of_range_is_refused():
    for name in ("voltage", "slew_rate"):
        for value in (0, -1, float("nan")):
            with pytest.raises(ValueError, match=name):
                Limits(**{name: value})
    with pytest.raises(ValueError, match="dt"):
        Limits(slew_rate=1).applied((1, 1), (0, 0), -1)
