"""Native functions and classes: their signatures, and calls that fit none."""

import inspect
import pickle
import pydoc
from types import WrapperDescriptorType

import numpy as np
import pytest

import robsim
from robsim import Frame, RobotModel, Spin, _core, find_blobs
from robsim.imaging import PlaneMap

NATIVE = {
    name: value
    for name, value in vars(_core).items()
    if callable(value) and not name.startswith("_") and name != "Arrival"  # an enum of pybind11's
}


def methods(cls):
    return [
        (f"{cls.__name__}.{name}", getattr(cls, name))
        for name, value in vars(cls).items()
        if callable(value) and (not name.startswith("_") or name in ("__init__", "__call__"))
        if not isinstance(value, WrapperDescriptorType)  # made by the core alone
    ]


ALL = [
    *((name, value) for name, value in NATIVE.items() if not isinstance(value, type)),
    *(entry for value in NATIVE.values() if isinstance(value, type) for entry in methods(value)),
]


@pytest.mark.long
@pytest.mark.parametrize(("name", "function"), ALL, ids=[name for name, _ in ALL])
def test_every_native_function_has_a_signature_and_its_types_in_the_doc(name, function):
    signature = inspect.signature(function)
    first = function.__doc__.strip().splitlines()[0]
    assert all(parameter in first for parameter in signature.parameters)
    assert "SupportsFloat" not in first


@pytest.mark.parametrize(
    ("function", "signature"),
    [
        (
            Frame,
            "(image, *, copy=True, t=None, t_arrival=None, epoch=None, index=0, "
            "plane_map=Ellipsis, headings=None)",
        ),
        (Spin, "(voltage=0.05)"),
        (RobotModel.predict, "(self, pose_1, pose_2, u, *, unwrapped=False)"),
        (RobotModel().predict, "(pose_1, pose_2, u, *, unwrapped=False)"),
        (PlaneMap.from_points, "(pixels, positions, intrinsics=None)"),
        (robsim.wrap_angle, "(angle)"),
    ],
)
def test_signatures_are_as_in_the_documentation(function, signature):
    assert str(inspect.signature(function)) == signature


IMAGE = np.zeros((4, 4, 3), np.uint8)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: find_blobs(), "find_blobs() needs the argument image"),
        (
            lambda: find_blobs(IMAGE, [], None),
            "find_blobs() takes 2 positional arguments, got 3: give the others by name, as in "
            "markers=...",
        ),
        (lambda: Spin(1, 2), "Spin() takes 1 positional argument, got 2"),
        (
            lambda: find_blobs(IMAGE, [], regoin=3),
            "find_blobs() has no argument 'regoin'; did you mean 'region'?",
        ),
        (
            lambda: Frame(IMAGE, time=3),
            "Frame() has no argument 'time': it takes image, copy, t, t_arrival, epoch, index, "
            "plane_map, headings",
        ),
        (lambda: Spin(current=3), "Spin() has no argument 'current': it takes voltage"),
        (lambda: robsim.Unicycle(x=3), "Unicycle() has no argument 'x': it takes none"),
        (lambda: Spin(1, voltage=3), "Spin() got two values for voltage"),
        (lambda: RobotModel.predict(), "predict() is a method: it needs an object"),
        (lambda: Spin("1"), "voltage must be a number, got '1'"),
        (lambda: RobotModel(None), "parameters must be a RobotParameters, got None"),
        (
            lambda: find_blobs(IMAGE, "red"),
            "colors must be a list of ColorClass objects, got 'red'",
        ),
        (
            lambda: robsim.DriveAround(hold=2**31),
            "hold must be an int within -2147483648..2147483647, got 2147483648",
        ),
        (lambda: robsim.DriveAround(hold=1.5), "hold must be an int, got 1.5"),
        (
            lambda: robsim.Observation(IMAGE),
            "frame must be a Frame or None, got a uint8 array of shape (4, 4, 3)",
        ),
        (lambda: Spin()(3), "step must be a Step, got 3"),
        (
            lambda: robsim.wrap_angle("a"),
            "angle must be a number or an array of numbers (rad), got 'a'",
        ),
    ],
)
def test_a_call_that_fits_no_signature_says_what_is_wrong(call, message):
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == message


def test_an_argument_that_cannot_be_shown_is_refused_all_the_same():
    class Shy:
        def __repr__(self):
            raise RuntimeError("no")

    with pytest.raises(TypeError):
        Spin(Shy())


def test_a_type_error_of_a_callback_stays_what_it_is():
    def control(step):
        return 1 + "1", 0

    with pytest.raises(TypeError, match="unsupported operand") as caught:
        robsim.Simulation(control=control).run(1)
    assert caught.traceback[-1].name == "control"


@pytest.mark.parametrize("name", ["find_blobs", "locate", "wrap_angle"])
def test_native_functions_are_functions_of_their_module(name):
    function = getattr(robsim, name)
    assert repr(function) == f"<built-in function {name}>"
    assert pickle.loads(pickle.dumps(function)) is function
    assert "pybind11" not in pydoc.render_doc(function)


def test_a_static_method_is_one_of_its_class():
    assert pickle.loads(pickle.dumps(Frame.from_bgr)) == Frame.from_bgr
    assert "record" not in pydoc.render_doc(Frame.from_bgr)
