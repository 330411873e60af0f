"""The values of the core: equal, hashed, copied, pickled and shown by what they are made of."""

import copy
import pickle
import subprocess
import sys
from unittest.mock import ANY

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robsim import ColorClass, DriveAround, Replay, RobotModel, RobotParameters, Spin, Unicycle
from robsim.vision import MarkerLayout

TRIANGLE = np.array([[0, 0], [4, 0], [4, 4]])

# Two of each kind that differ.
PAIRS = [
    (Spin(), Spin(0.1)),
    (DriveAround(), DriveAround(hold=3)),
    (Replay([(1, 2)]), Replay([(1, 2), (3, 4)])),
    (RobotParameters(), RobotParameters(motor_gain=(0.05, 0.06))),
    (RobotModel(), RobotModel(RobotParameters(mass=0.31))),
    (ColorClass("red", u=(1, 2)), ColorClass("red", u=(1, 3))),
    (MarkerLayout(43, 14), MarkerLayout(43, 14, maximum_blobs=3)),
    (
        MarkerLayout.from_markers(TRIANGLE, TRIANGLE + np.array((0, 9))),
        MarkerLayout.from_markers(TRIANGLE, TRIANGLE + np.array((0, 8))),
    ),
]
VALUES = [*(one for pair in PAIRS for one in pair), Unicycle()]
LONG = (Replay, RobotModel)  # their repr is for reading
NAMES = {
    name: value
    for name, value in globals().items()
    if isinstance(value, type) and value.__module__.startswith("robsim")
}


class Tired(Spin):
    """A controller of the user's own that builds on a ready one."""

    def __init__(self, voltage, hours):
        super().__init__(voltage)
        self.hours = hours


def copies(value):
    yield from (copy.copy(value), copy.deepcopy(value))
    yield from (pickle.loads(pickle.dumps(value, p)) for p in range(pickle.HIGHEST_PROTOCOL + 1))


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_a_copy_is_equal(value):
    for other in copies(value):
        assert type(other) is type(value)
        assert other == value
        assert hash(other) == hash(value)
        assert repr(other) == repr(value)


@pytest.mark.parametrize(("one", "other"), PAIRS, ids=repr)
def test_values_with_other_fields_differ(one, other):
    assert one != other
    assert len({one, other, *copies(one), *copies(other)}) == 2


@pytest.mark.parametrize("value", [v for v in VALUES if type(v) not in LONG], ids=repr)
def test_the_repr_is_what_one_would_type(value):
    assert eval(repr(value), dict(NAMES)) == value


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_nothing_of_another_kind_is_equal(value):
    assert value != 3
    assert value is not None
    assert value == ANY  # the other side is asked
    assert all(value != other for other in VALUES if other is not value)


def test_a_class_of_the_users_own_keeps_what_it_adds():
    tired = Tired(0.1, [3])
    for other in copies(tired):
        assert type(other) is Tired
        assert other == tired
        assert other.hours == [3]
    assert tired != Tired(0.1, [4])
    assert tired != Spin(0.1)
    assert Spin(0.1) != tired
    assert repr(tired) == "Tired(voltage=0.1)"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_bit_of_a_number_is_kept(voltage):
    spin = pickle.loads(pickle.dumps(Spin(voltage)))
    assert spin.voltage.hex() == voltage.hex()
    assert eval(repr(spin), dict(NAMES)).voltage.hex() == voltage.hex()


def test_a_pickle_is_checked_as_the_constructor_is():
    drive = DriveAround.__new__(DriveAround)
    with pytest.raises(ValueError, match="hold must be at least 1"):
        drive.__setstate__(((0.0, 1.0, 0), {}))


@pytest.mark.long
def test_another_process_reads_a_pickle():
    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer))"
    run = subprocess.run(
        [sys.executable, "-c", code], input=pickle.dumps(VALUES), capture_output=True, check=True
    )
    assert run.stdout.decode().strip() == repr(VALUES)


def test_a_layout_of_positions():
    layout = MarkerLayout.from_positions((1, 2), [3, 4.5], red_area=5, maximum_blobs=6)
    assert layout.red.tolist() == [1, 2]
    assert layout.blue.tolist() == [3, 4.5]
    assert (layout.red_area, layout.maximum_blobs) == (5, 6)
    assert np.isnan(layout.blue_area)
    assert MarkerLayout.from_positions((-14, 21.5), (-14, -21.5)) == MarkerLayout(43, 14)
