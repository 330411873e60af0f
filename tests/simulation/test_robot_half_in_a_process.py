"""The robot half in a process of its own gives the same bytes as one process that does all."""

import numpy as np
import pytest

import robsim
from remote_half import CONTROLS, RemoteHalf, approach

pytestmark = pytest.mark.long  # starts processes

SEED = 5
STEPS = 40
WORLD = {
    "resolution": (300, 300),
    "noise": robsim.GaussianNoise(10),
    "dropout": robsim.Dropout(0.1, 3),
    "start": (300, 400, 1.0),
    "seed": SEED,
}


@pytest.fixture
def run_remotely(tmp_path):
    """Run the robot half in another process; return both traces, and the last input sent."""
    started = []

    def run(**options):
        sim = robsim.Simulation(**WORLD)
        remote = RemoteHalf(sim, tmp_path, seed=SEED, **options)
        started.append(remote)
        trace = sim.run(STEPS)
        return trace, *remote.end()

    yield run
    for remote in started:
        remote.abandon()


def run_at_home(control):
    sim = robsim.Simulation(
        **WORLD,
        identify_from="measurement",
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        control=control,
    )
    trace = sim.run(STEPS)
    # Only who knows the truth knows of a bounce, and makes no sample of it.
    assert not trace.bounced.any()
    return trace


def assert_same(trace, expected, columns):
    for column in columns:
        assert getattr(trace, column).tobytes() == getattr(expected, column).tobytes(), column


STAGES = ("pose_measured", "pose_held", "pose_estimated", "covariance", "state", "parameters")


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_robot_half_in_a_process_gives_the_same_bytes(run_remotely):
    expected = run_at_home(CONTROLS["drive around"])
    assert 0 < np.isnan(expected.pose_measured).any(axis=1).sum() < STEPS
    assert np.isfinite(expected.parameters[-1]).all()
    world, stop, robot = run_remotely(control="drive around")
    assert_same(world, expected, ("pose_true", *STAGES, "u"))
    assert_same(robot, expected, ("t", *STAGES, "u", "standard_errors_unscaled"))
    for color, centroids in expected.blobs.items():
        assert robot.blobs[color].tobytes() == centroids.tobytes()
    np.testing.assert_array_equal(stop, (0, 0))


def test_a_robot_half_that_is_told_what_the_motors_got_gives_the_same_bytes(run_remotely):
    limit = 0.7
    expected = run_at_home(lambda step: np.clip(approach(step), -limit, limit))
    world, stop, robot = run_remotely(control="approach", limit=limit)
    assert_same(world, expected, ("pose_true", *STAGES, "u"))
    assert_same(robot, expected, STAGES)
    # What the robot half sent is recorded there, not what arrived.
    assert np.abs(robot.u).max() > limit
    np.testing.assert_array_equal(np.clip(robot.u, -limit, limit), expected.u)
    np.testing.assert_array_equal(stop, (0, 0))
