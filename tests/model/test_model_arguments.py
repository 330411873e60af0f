"""What is no parameter of a robot, no model and no input is refused in its name."""

import numpy as np
import pytest

from refusals import INF, NAN, NOT_FINITE, POSE, Refusal, options, refusals
from robsim import RobotModel, RobotParameters

pytestmark = pytest.mark.long

MODEL = RobotModel()
THETA = MODEL.theta


def with_entry(row, column, value):
    theta = np.array(THETA)
    theta[row, column] = value
    return theta


def model_of(**parameters):
    return RobotModel(RobotParameters(**parameters))


NO_LENGTH = (0, -0.0, -1, None, "1", 1j, [1], 10**400)
NO_MOTORS = (
    *(None, 1, "12", "ab", (), (1,), (1, 2, 3), (NAN, 1), (1, INF), (1, None), (1, 1j)),
    {1, 2},  # which is left, which right?
)
NOT_PHYSICAL = {
    "mass": (0.0, -1.0),
    "inertia": (0.0, NAN),
    "wheel_radius": (0.0,),
    "linear_friction angular_friction wheel_base": (-0.1,),
    "dt": (0.0, INF),
    "motor_gain": ((NAN, 1.0),),
    "motor_offset": ((0.0, INF),),
}
UNSTABLE = {
    "linear_friction angular_friction": (0,),
    "mass inertia dt": (1e308,),
    **{"wheel_radius": (5e-324,), "motor_gain": ((1e308, 0),)},
}
NO_INPUT = (None, 5, "ab", (1,), (1, 2, 3), (NAN, 1), (1, INF), [[[1, 2]]], (None, 1), ["a", "b"])
NO = (NAN, 0, 0)
NO_POSE = (None, 5, "abc", (), (1, 2), NO, [[1, 2]], [[[1, 2, 3]]])
NO_THETA = {
    "theta": (
        *(None, 5, "abc", THETA.T, THETA[0], THETA * NAN, [], THETA[None], [["a"] * 5] * 3),
        with_entry(1, 2, INF),
    ),
    "a1X": (with_entry(0, 0, 0), with_entry(0, 0, 2), with_entry(0, 0, -1)),
    "a1Y": (with_entry(1, 0, 2),),
    "a1P": (with_entry(2, 0, 2.5),),
    "a2X": (with_entry(0, 1, 50),),
}


@refusals(
    options(
        RobotParameters,
        {
            "mass inertia wheel_radius wheel_base dt": (*NO_LENGTH, *NOT_FINITE),
            "linear_friction angular_friction": (-1, -5e-324, NAN, INF, None, "1", [1]),
            "motor_gain motor_offset": NO_MOTORS,
            "mas": (3,),
        },
    ),
    options(model_of, UNSTABLE),
    options(
        model_of,
        {"linear_friction": (0.0,), "mass": (1e20,)},
        says="a1X must lie between 0 and 2.*{name}",
        raises=ValueError,
    ),
    options(
        model_of,
        {"angular_friction": (0.0,)},
        says="a1P must lie between 0 and 2.*{name}",
        raises=ValueError,
    ),
    [
        Refusal(
            RobotModel.from_theta,
            f"a1{axis}",
            [with_entry(row, 0, a1) for a1 in (0.0, 2.0, -0.5, 2.5)],
            "{name} must lie between 0 and 2",
            ValueError,
        )
        for row, axis in enumerate("XYP")
    ],
    options(RobotParameters, NOT_PHYSICAL, raises=ValueError),
    Refusal(RobotModel, "parameters", (None, 5, "lab", MODEL, THETA)),
    [Refusal(RobotModel.from_theta, name, bad) for name, bad in NO_THETA.items()],
    options(RobotModel.from_theta, {"dt": (0, -1, NAN, INF, None, "0.2", [1])}, THETA),
    Refusal(lambda value: MODEL.predict(POSE, POSE, value), "u", NO_INPUT),
    Refusal(lambda value: MODEL.predict([POSE] * 3, POSE, value), "u", (*NO_INPUT, [[1, 2]] * 2)),
    Refusal(lambda value: MODEL.jacobian(POSE, POSE, value), "u", NO_INPUT),
    Refusal(lambda value: MODEL.jacobian(value, POSE, (1, 1)), "pose_1", (*NO_POSE, [POSE, NO])),
    Refusal(MODEL.steps_in, "dt", (0, -0.2, 0.1, 0.27, NAN, INF, 1e300, None, "0.2", [0.2])),
)
def test_models(refusal):
    refusal()
