import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robsim import ParameterMismatch, PoseNoise, RobotModel, RobotParameters, WheelNoise

MODEL = RobotModel()
SIGMA = (0.5, 0.25, 0.01)
CORRELATED = [[4, 1, 0], [1, 2, 0], [0, 0, 0]]
VALUES = (PoseNoise.from_sigma(*SIGMA), PoseNoise(CORRELATED), WheelNoise(1), ParameterMismatch(0))


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_they_are_values(value):
    for other in (copy.deepcopy(value), pickle.loads(pickle.dumps(value)), eval(repr(value))):
        assert other == value
        assert hash(other) == hash(value)
        assert repr(other) == repr(value)
    assert len({*VALUES}) == 4


# --- noise of the pose


def test_a_filter_can_take_the_covariance():
    noise = PoseNoise.from_sigma(*SIGMA)
    assert np.allclose(noise.Q, np.diag(np.square(SIGMA)))
    assert np.allclose(noise.sigma, SIGMA)
    assert noise == PoseNoise(np.diag(np.square(SIGMA)))
    assert PoseNoise(CORRELATED).Q.tolist() == CORRELATED


@given(st.lists(st.floats(-1e3, 1e3), min_size=9, max_size=9))
def test_every_covariance_is_one(numbers):
    root = np.reshape(numbers, (3, 3)) * ((1,), (1,), (1e-4,))
    covariance = root @ root.T
    symmetric = (covariance + covariance.T) / 2
    assert np.array_equal(PoseNoise(symmetric).Q, symmetric)


def test_a_heading_noise_in_degrees_is_told():
    with pytest.warns(UserWarning, match="radians"):
        PoseNoise.from_sigma(1, 1, 5)
    with pytest.warns(UserWarning, match="radians"):
        PoseNoise(np.diag((1, 1, 25)))
    PoseNoise.from_sigma(100, 100, 3)  # no warning, which would be an error


def test_what_is_no_covariance_says_why():
    with pytest.raises(ValueError, match="symmetric"):
        PoseNoise([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])
    for wrong in (np.diag((1, -1, 1)), [[1, 2, 0], [2, 1, 0], [0, 0, 0]]):
        with pytest.raises(ValueError, match="positive semi-definite"):
            PoseNoise(wrong)
    for wrong in (np.eye(2), np.eye(3)[None], np.eye(3) * np.nan):
        with pytest.raises(ValueError, match="covariance"):
            PoseNoise(wrong)
    sigmas = dict.fromkeys(("x", "y", "heading"), 1)
    for name, largest in (("x", 1e6), ("y", 1e6), ("heading", 1)):
        PoseNoise.from_sigma(**sigmas | {name: largest})
        for sigma in (-1e-9, 1e300):
            with pytest.raises(ValueError, match=rf"\b{name}\b"):
                PoseNoise.from_sigma(**sigmas | {name: sigma})


# --- noise of the wheels


@pytest.mark.random
def test_the_covariance_is_that_of_the_noise_in_the_model(rng):
    noise, heading, u = WheelNoise((0.3, 0.1)), 0.7, np.array((0.5, 0.4))
    pose = (100.0, 200.0, heading)
    w = rng.standard_normal((20_000, 2)) * noise.sigma
    poses = np.array([MODEL.predict(pose, pose, u + one) for one in w])
    assert np.allclose(noise.Q(MODEL, heading), np.cov(poses.T), rtol=0.05, atol=1e-6)


@given(st.floats(0, 10), st.floats(0, 10), st.floats(-10, 10))
def test_the_covariance_is_symmetric_and_semidefinite(left, right, heading):
    PoseNoise(WheelNoise((left, right)).Q(MODEL, heading))


def test_the_sigma_of_wheels():
    assert WheelNoise(0.5) == WheelNoise([0.5, 0.5]) == WheelNoise(np.array((0.5, 0.5)))
    assert WheelNoise(0.5).sigma == (0.5, 0.5)
    for sigma in (-1e-9, (1, -1), (1,), (1, 2, 3), {1, 2}):
        with pytest.raises((TypeError, ValueError), match="sigma"):
            WheelNoise(sigma)


# --- other parameters


def test_it_is_as_if_gains_and_frictions_were_drawn(monkeypatch):
    numbers = iter([1, -2, 3.1, 3, -0.5])
    monkeypatch.setattr(
        "robsim.simulation.world.disturbances.random_normal", lambda seed, counter: next(numbers)
    )
    world = ParameterMismatch(0.1).draw(MODEL, np.random.default_rng(1))
    gain, p = RobotParameters().motor_gain, RobotParameters()
    other = RobotParameters(
        motor_gain=(1.1 * gain[0], 0.8 * gain[1]),
        linear_friction=1.3 * p.linear_friction,
        angular_friction=0.95 * p.angular_friction,
    )
    assert np.allclose(world.theta, RobotModel(other).theta, rtol=1e-12, atol=1e-15)
    assert world.dt == MODEL.dt


def test_a_mismatch_of_none_and_of_too_much():
    rng = np.random.default_rng(1)
    assert np.array_equal(ParameterMismatch(0).draw(MODEL, rng).theta, MODEL.theta)
    ParameterMismatch(0.3)
    for sigma in (-1e-9, 0.31):
        with pytest.raises(ValueError, match="sigma"):
            ParameterMismatch(sigma)
    unusual = RobotModel.from_theta(MODEL.theta * ((0.5,), (1,), (1,)))
    with pytest.raises(ValueError, match="model"):
        ParameterMismatch(0.1).draw(unusual, rng)


@pytest.mark.random
def test_the_drawn_gains_have_the_spread_that_was_asked_for(rng):
    theta = np.array([ParameterMismatch(0.05).draw(MODEL, rng).theta for _ in range(2000)])
    assert np.array_equal(theta[:, 0], theta[:, 1])
    # b2P/b2X = -L/2 DX/DP depends on the friction alone, b1X/b2X on the gains alone.
    ratio = theta[:, 0, 2] / theta[:, 0, 3]
    assert np.std(ratio) == pytest.approx(0.05 * np.sqrt(2), rel=0.1)
    rho = 1 / (theta[:, 0, 0] - 1) - 1
    assert np.std(rho / (1 / (MODEL.theta[0, 0] - 1) - 1)) == pytest.approx(0.05, rel=0.1)


@pytest.mark.random
@pytest.mark.parametrize("friction", [1e-3, 0.1, 100.0])
def test_every_world_is_stable(rng, friction):
    model = RobotModel(RobotParameters(linear_friction=friction, angular_friction=friction))
    for _ in range(300):
        theta = ParameterMismatch(0.3).draw(model, rng).theta
        assert (theta[:, 0] > 1).all()
        assert np.allclose(theta[:, 0] + theta[:, 1], 1)
