"""Calls of native functions that fit no signature, and what help and pickle know of them."""

import inspect

import numpy as np
import pytest

import robsim
from robsim import Frame, RobotModel, Spin, find_blobs
from robsim.vision import PlaneMap

IMAGE = np.zeros((4, 4, 3), np.uint8)
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
        (lambda: find_blobs(IMAGE, [], None), "2 positional", "got 3", "markers="),
        (lambda: find_blobs(IMAGE, [], regoin=3), "'regoin'", "'region'"),
        (lambda: Frame(IMAGE, time=3), "'time'", "t_arrival, epoch"),
        (lambda: robsim.Unicycle(x=3), "'x'", "none"),
        (lambda: RobotModel.predict(), "predict", "object"),
        (lambda: Spin("1"), "voltage must be a number", "'1'"),
        (lambda: RobotModel(None), "parameters", "RobotParameters", "None"),
        (lambda: find_blobs(IMAGE, "red"), "colors", "ColorClass", "'red'"),
        (lambda: robsim.DriveAround(hold=2**31), "hold", "2147483647, got 2147483648"),
        (lambda: robsim.Observation(IMAGE), "frame", "uint8 array of shape (4, 4, 3)"),
        (lambda: Spin()(3), "step must be a Step"),
    ):
        with pytest.raises(TypeError) as caught:
            call()
        for word in words:
            assert word in str(caught.value)
        assert "incompatible" not in str(caught.value)  # nor pybind11's list of signatures


def test_a_type_error_of_a_callback_stays_what_it_is():
    def control(step):
        return 1 + "1", 0

    with pytest.raises(TypeError, match="unsupported operand") as caught:
        robsim.Simulation(control=control).run(1)
    assert caught.traceback[-1].name == "control"
