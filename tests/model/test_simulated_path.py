"""The path of the model and its derivatives, which the fits are built on."""

import numpy as np
import pytest

import robsim
from robsim._core import path_sensitivities, simulated_path

MODEL = robsim.RobotModel()
FIRST = np.array([(600, 600, 0.1), (601, 600, 0.15)])


def inputs(steps):
    return np.random.default_rng(1).uniform(-0.5, 1.5, (steps, 2))


def test_each_pose_is_the_prediction_from_the_two_before():
    u = inputs(60) + np.array((1.5, 0))
    path = simulated_path(MODEL.theta, FIRST, u)
    np.testing.assert_array_equal(path[:2], FIRST)
    assert path[-1, 2] > np.pi
    predicted = MODEL.predict(path[1:-1], path[:-2], u[1:-1], unwrapped=True)
    np.testing.assert_array_equal(path[2:], predicted)


def test_the_sensitivities_are_the_derivatives_of_the_path():
    u = inputs(40)
    result = path_sensitivities(MODEL.theta, simulated_path(MODEL.theta, FIRST, u), u)
    step = 1e-6
    unknowns = np.concatenate([FIRST.T.ravel(), MODEL.theta.ravel()])
    for i in range(21):
        paths = []
        for sign in (1, -1):
            moved = unknowns.copy()
            moved[i] += sign * step
            paths.append(simulated_path(moved[6:].reshape(3, 5), moved[:6].reshape(3, 2).T, u))
        expected = (paths[0] - paths[1]) / (2 * step)
        scale = max(np.abs(expected).max(), 1)
        np.testing.assert_allclose(result[:, :, i] / scale, expected / scale, atol=1e-6)


def test_a_path_needs_two_poses_and_an_input_for_each_step():
    for theta, first, u, name in (
        (MODEL.theta.T, FIRST, inputs(3), "theta"),
        (MODEL.theta, FIRST[:1], inputs(3), "first"),
        (MODEL.theta, FIRST, inputs(1), "u"),
        (MODEL.theta, FIRST, inputs(3)[0], "u"),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            simulated_path(theta, first, u)
    with pytest.raises(ValueError, match=r"\bu\b"):
        path_sensitivities(MODEL.theta, np.zeros((3, 3)), inputs(4))
