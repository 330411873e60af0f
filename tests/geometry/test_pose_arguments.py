"""What is no pose is refused by all that take one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from refusals import NAN, NO_POSE, POSE, Refusal, refusals, refuses
from robsim import Estimate, Measurement, RobotModel, Simulation
from scenes import small_renderer

MODEL = RobotModel()

# These take an array of poses as well.
MODEL_TAKERS = {
    "pose_1": lambda pose: MODEL.predict(pose, POSE, (0, 0)),
    "pose_2": lambda pose: MODEL.predict(POSE, pose, (0, 0)),
    "pose_1 of jacobian": lambda pose: MODEL.jacobian(pose, POSE, (0, 0)),
    "pose_2 of jacobian": lambda pose: MODEL.jacobian(POSE, pose, (0, 0)),
}
POSE_TAKERS = {
    "pose of Measurement": Measurement,
    "pose of Estimate": lambda pose: Estimate(pose, np.eye(3)),
    "pose of render": lambda pose: small_renderer().render(pose),
    "start": lambda pose: Simulation(start=pose),
}


def each_of(takers):
    cases = [(name.split()[0], take) for name, take in takers.items()]
    return pytest.mark.parametrize(("name", "take"), cases)


OTHER_SHAPES = npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4).filter(
    lambda shape: shape != (3,)
)


NO_MATRIX = (None, 5, "abc", np.eye(2), np.eye(3) * NAN, np.zeros(9), [["a"] * 3] * 3)
NO_NUMBERS = (
    *(["1", "2", "3"], np.array(["1", "2", "3"]), np.array([1 + 1j, 0, 0]), [object()] * 3),
    *(np.array([1, 2, 3], "m8[s]"), np.array(["2020-01-01"] * 3, "M8[D]")),
)


@pytest.mark.long
@refusals(
    [Refusal(take, of.split()[0], NO_POSE) for of, take in POSE_TAKERS.items()],
    [
        Refusal(take, of.split()[0], [bad for bad in NO_POSE if bad != [POSE]])
        for of, take in MODEL_TAKERS.items()
    ],
    Refusal(Measurement, "pose", NO_NUMBERS, raises=TypeError),
    Refusal(lambda value: Estimate(POSE, value), "covariance", NO_MATRIX),
    Refusal(
        lambda value: Estimate(POSE, np.eye(3), value),
        "state",
        (5, "abc", np.eye(2), [NAN], [None], ["a"]),
    ),
)
def test_what_is_no_pose(refusal):
    refusal()


@pytest.mark.long
@each_of(POSE_TAKERS)
@settings(max_examples=40, deadline=None)
@given(shape=OTHER_SHAPES)
def test_poses_of_other_shapes(name, take, shape):
    refuses(name, take, np.zeros(shape))


@pytest.mark.long
@each_of(MODEL_TAKERS)
@settings(max_examples=40, deadline=None)
@given(shape=OTHER_SHAPES.filter(lambda shape: len(shape) != 2 or shape[1] != 3))
def test_arrays_of_poses_of_other_shapes(name, take, shape):
    refuses(name, take, np.zeros(shape))


@given(pose=npst.arrays(float, 3, elements=st.floats(allow_subnormal=True)))
def test_a_pose_of_floats_is_kept_or_refused(pose):
    if np.isfinite(pose).all():
        x, y, heading = Measurement(pose).pose
        assert (x, y) == (pose[0], pose[1])
        assert -np.pi < heading <= np.pi
    else:
        assert "finite" in refuses("pose", Measurement, pose)


def test_poses_of_any_layout_are_taken():
    for pose in (
        list(POSE),
        np.array(POSE, dtype=">f8"),
        np.array(POSE, dtype=np.float32),
        np.array([3.0, 2.0, 1.0])[::-1],
        np.arange(9.0).reshape(3, 3, order="F")[0] * 0 + POSE,
        np.array([1, 2, 3]),
        range(1, 4),
    ):
        np.testing.assert_array_equal(Measurement(pose).pose, POSE)
