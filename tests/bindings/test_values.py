"""Native values and calls: equality, copies, text, signatures."""

import copy
import inspect
import pickle
from unittest.mock import ANY

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from robsim import (
    ColorClass,
    DriveAround,
    Estimate,
    FollowPath,
    Frame,
    GoToPoint,
    Measurement,
    Observation,
    RecursiveLeastSquares,
    Replay,
    RobotModel,
    RobotParameters,
    Spin,
    Step,
    Unicycle,
    _core,
    find_blobs,
)
from robsim._core import WorldState
from robsim.estimation import Sample, least_squares
from robsim.vision import Blob, MarkerLayout, PlaneMap

# --- values


TRIANGLE = np.array([[0, 0], [4, 0], [4, 4]])
IMAGE = np.arange(4 * 5 * 3, dtype=np.uint8).reshape(4, 5, 3)
BLOB = {"area": 3, "centroid": (1.5, 2), "bounding_box": (1, 2, 2, 3), "at_border": True}
FIT = least_squares(np.eye(3)[:2], [1, 2])  # with NaN and infinity

# Two of each kind that differ.
PAIRS = [
    (Spin(), Spin(0.1)),
    (DriveAround(), DriveAround(hold=3)),
    (Replay([(1, 2)]), Replay([(1, 2), (3, 4)])),
    (GoToPoint(1, 2), GoToPoint(1, 2, turn_gain=1)),
    (FollowPath([(1, 2)]), FollowPath([(1, 2), (3, 4)])),
    (RobotParameters(), RobotParameters(motor_gain=(0.05, 0.06))),
    (RobotModel(), RobotModel(RobotParameters(mass=0.31))),
    (ColorClass("red", u=(1, 2)), ColorClass("red", u=(1, 3))),
    (MarkerLayout(43, 14), MarkerLayout(43, 14, maximum_blobs=3)),
]
# Their repr is for reading.
RECORDS = [
    (
        MarkerLayout.from_markers({"left": TRIANGLE, "right": TRIANGLE + np.array((0, 9))}),
        MarkerLayout.from_markers({"left": TRIANGLE, "right": TRIANGLE + np.array((0, 8))}),
    ),
    (PlaneMap(), PlaneMap.scaled((10, 10), (20, 20))),
    (Frame(IMAGE, t=0.2, index=3), Frame(IMAGE + 1, t=0.2, index=3)),
    (Blob("red", **BLOB), Blob("blue", **BLOB)),
    (Measurement((1, 2, 3)), Measurement((1, 2, 3.1))),
    (Estimate((1, 2, 3), np.eye(3)), Estimate((1, 2, 3), np.eye(3), [4])),
    (Sample(np.ones((3, 5)), (1, 2, 3), 4), Sample(np.ones((3, 5)), (1, 2, 3), 5)),
    (Observation(Frame(IMAGE)), Observation(t=3, last_u=(1, 2), measurement=(1, 2, 3))),
    (WorldState((1, 2, 3), (1, 2, 3), (0, 1), k=3), WorldState((1, 2, 3), (1, 2, 3), (0, 1))),
    (FIT, least_squares(np.eye(3), [1, 2, 4])),
]
RECORDED = [one for pair in RECORDS for one in pair]
VALUES = [*(one for pair in PAIRS for one in pair), Unicycle(), *RECORDED]
LONG = (FollowPath, Replay, RobotModel, *(type(one) for one in RECORDED))
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
    if hasattr(value, "__setstate__"):  # of the core
        make, arguments, state = value.__reduce__()
        other = make(*arguments)
        other.__setstate__(state)
        yield other


def test_a_copy_is_equal():
    for value in VALUES:
        for other in copies(value):
            assert type(other) is type(value)
            assert other == value
            assert hash(other) == hash(value)
            assert repr(other) == repr(value)


def test_values_with_other_fields_differ():
    for one, other in PAIRS + RECORDS:
        assert one != other
        assert len({one, other, *copies(one), *copies(other)}) == 2
    for value in VALUES:
        assert value != 3
        assert value == ANY  # the other side is asked
        assert all(value != other for other in VALUES if other is not value)


def test_the_repr_is_what_one_would_type():
    for value in VALUES:
        if type(value) not in LONG:
            assert eval(repr(value), dict(NAMES)) == value


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


def test_a_pickle_is_checked_as_the_constructor_is():
    drive = DriveAround.__new__(DriveAround)
    (low, high, _, *others), own = DriveAround().__getstate__()
    with pytest.raises(ValueError, match="hold"):
        drive.__setstate__(((low, high, 0, *others), own))
    for state in ([], [0.0] * 7, [np.nan] * 84):
        filters = RecursiveLeastSquares.__new__(RecursiveLeastSquares)
        with pytest.raises(ValueError, match="state"):
            filters.__setstate__(((5, 3, 1.0, 1e9, state), {}))


def updated(filters, rng):
    filters.update(rng.normal(size=(40, 3, 5)), rng.normal(size=(40, 3)))
    return filters


def test_a_copy_of_an_estimator_goes_on_as_the_estimator_does(rng):
    filters = updated(RecursiveLeastSquares(5, n_filters=3, forgetting=0.98), rng)
    phi, y = rng.normal(size=(3, 5)), rng.normal(size=3)
    for other in copies(filters):
        assert other == filters
        assert other.n_samples.tolist() == [40, 40, 40]
        other.update(phi, y)
        assert other != filters
    filters.update(phi, y)
    assert other == filters
    np.testing.assert_array_equal(other.P, filters.P)
    with pytest.raises(TypeError, match="unhashable"):
        hash(filters)


@pytest.mark.long
def test_a_copy_of_a_step_has_all_but_the_estimator():
    sim = robsim.Simulation(control=DriveAround(), measure=True, estimate_parameters=True)
    step = sim.run(20) and sim.last_step
    for other in copies(step):
        assert other == step
        assert (other.k, other.t, other.dt) == (step.k, step.t, step.dt)
        assert other.measurement == step.measurement is not None
        assert other.sample == step.sample is not None
        assert other.u.tolist() == step.u.tolist()
        assert other.frame == step.frame
        assert other.blobs == step.blobs
        assert other.markers == step.markers
        assert other.estimator is None
    sim.run(1)
    assert sim.last_step != step


def test_a_step_made_by_hand_tests_a_callback():
    step = Step(k=3, measurement=(600, 500, 0.1))
    assert (step.t, step.dt, step.frame, step.blobs) == (pytest.approx(0.6), 0.2, None, {})
    u1, u2 = robsim.GoToPoint(600, 900)(step)
    assert u1 > u2  # the point lies to the right
    with pytest.raises(RuntimeError, match=r"without markers=\.\.\."):
        _ = step.markers
    sim = robsim.Simulation()
    seen = Step(frame=sim.frame, colors=sim.colors, markers=sim.markers)
    assert seen.blobs == sim.last_step.blobs


@pytest.mark.long
@given(st.integers(0, 2**31 - 1), st.integers(1, 7), st.floats(-10, 10))
def test_frames_are_equal_if_every_pixel_is(index, value, t):
    image = np.zeros((3, 2, 3), np.uint8)
    one = Frame(image, t=t, index=index)
    image[2, 1, 2] = value
    assert one != Frame(image, t=t, index=index)
    image[2, 1, 2] = 0
    assert one == Frame(image, t=t, index=index)
    assert hash(one) == hash(Frame(image, t=t, index=index))


# --- signatures


BLACK = np.zeros((4, 4, 3), np.uint8)
NATIVE = [
    *(Frame, Spin, RobotModel.predict, PlaneMap.from_points, find_blobs, robsim.locate),
    *(robsim.wrap_angle, robsim.DriveAround, robsim.estimation.least_squares),
]


def test_native_functions_have_signatures_and_their_types_in_the_doc():
    for function in NATIVE:
        signature = inspect.signature(function)
        doc = (function.__init__ if inspect.isclass(function) else function).__doc__
        first = doc.strip().splitlines()[0]
        assert all(parameter in first for parameter in signature.parameters)
        assert "SupportsFloat" not in first
    assert list(inspect.signature(RobotModel().predict).parameters) == [
        *("pose_1", "pose_2", "u", "unwrapped")
    ]


def test_a_call_that_fits_no_signature_says_what_is_wrong():
    for call, *words in (
        (lambda: find_blobs(), "find_blobs", "image"),
        (lambda: find_blobs(BLACK, [], None), "2 positional", "got 3", "markers="),
        (lambda: find_blobs(BLACK, [], regoin=3), "'regoin'", "'region'"),
        (lambda: Frame(BLACK, time=3), "'time'", "t_arrival, epoch"),
        (lambda: robsim.Unicycle(x=3), "'x'", "none"),
        (lambda: RobotModel.predict(), "predict", "object"),
        (lambda: Spin("1"), "voltage must be a number", "'1'"),
        (lambda: RobotModel(None), "parameters", "RobotParameters", "None"),
        (lambda: find_blobs(BLACK, "red"), "colors", "ColorClass", "'red'"),
        (lambda: robsim.DriveAround(hold=2**31), "hold", "2147483647, got 2147483648"),
        (lambda: robsim.Observation(BLACK), "frame", "uint8 array of shape (4, 4, 3)"),
        (lambda: Spin()(3), "step must be a Step"),
    ):
        with pytest.raises(TypeError) as caught:
            call()
        for word in words:
            assert word in str(caught.value)
        assert "incompatible" not in str(caught.value)  # nor pybind11's list of signatures


def members_of_native_classes():
    for kind in vars(_core).values():
        is_native = isinstance(kind, type)
        for name, member in vars(kind).items() if is_native else ():
            if not name.startswith("_"):
                yield f"{kind.__name__}.{name}", member


@pytest.mark.parametrize("wrong", [(), (None,), ({1: []},), (3, 3)])
def test_a_method_needs_an_object_of_its_class(wrong):
    """A call with None reaches no null pointer, and the message is not pybind11's."""
    for name, member in members_of_native_classes():
        if isinstance(member, property):
            with pytest.raises((TypeError, RuntimeError, AttributeError)):
                member.fget(*wrong)
        elif type(member).__name__ == "instancemethod":
            with pytest.raises(TypeError) as caught:
                member(*wrong)
            assert "incompatible" not in str(caught.value), name


def test_an_array_of_a_wrong_kind_is_named_as_one():
    with pytest.raises(TypeError, match="time must be an array of numbers, got "):
        _core.model_steps({1: []}, 1.0)


def test_a_type_error_of_a_callback_stays_what_it_is():
    def control(step):
        return 1 + "1", 0

    with pytest.raises(TypeError, match="unsupported operand") as caught:
        robsim.Simulation(control=control).run(1)
    assert caught.traceback[-1].name == "control"


def test_the_heading_of_a_sample_goes_on_beyond_half_a_turn():
    assert Sample(np.zeros((3, 5)), (1, 2, 3.5), 4).y.tolist() == [1, 2, 3.5]
