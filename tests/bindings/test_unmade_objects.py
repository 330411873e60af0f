"""Objects without a value of C++: `__new__` alone makes them."""

import copy
import pickle

import pytest

from robsim import _core

CLASSES = [one for one in vars(_core).values() if isinstance(one, type)]


@pytest.mark.sanitized
def test_an_object_without_its_constructor_is_refused():
    tried = 0
    for one in CLASSES:
        if issubclass(one, BaseException) or "__members__" in vars(one):
            continue
        unmade = one.__new__(one)
        looks = [name for name, value in vars(one).items() if isinstance(value, property)]
        for look in (*looks, "__getstate__"):
            if look not in vars(one):
                continue
            with pytest.raises(TypeError, match="without its constructor"):
                getattr(unmade, look)() if look == "__getstate__" else getattr(unmade, look)
            tried += 1
        if "__reduce__" in vars(one):
            with pytest.raises(TypeError, match="without its constructor"):
                copy.copy(unmade)
    assert tried > 100


def test_a_state_of_something_else_is_refused():
    for one in CLASSES:
        if "__setstate__" in vars(one) and "__members__" not in vars(one):
            with pytest.raises(TypeError, match="state must be what __getstate__ returned"):
                one.__new__(one).__setstate__({"x": 1})


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_what_has_no_pickle_is_refused_by_each_protocol(protocol):
    with pytest.raises(TypeError, match="MotorReceiver"):
        pickle.dumps(_core.MotorReceiver.__new__(_core.MotorReceiver), protocol)
