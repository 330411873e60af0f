"""A drive from end to end: seen by the camera, tracked, identified, saved and read again."""

import numpy as np
import pytest

import robsim


def test_a_drive_with_tracking_and_identification(tmp_path):
    sim = robsim.Simulation(
        robot="lab",
        area=(400, 400),
        headings=None,
        measure=True,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        identify_from="truth",
        control=robsim.DriveAround(low=-0.2, high=0.5, hold=5),
        process_noise=robsim.WheelNoise(0.001),
        seed=4,
    )
    trace = sim.run(120)

    # Where it is, as seen and as estimated.
    assert trace.seen.all()
    way = np.linalg.norm(np.diff(trace.pose_true[:, :2], axis=0), axis=1).sum()
    assert way > 100
    for poses, px, rad in ((trace.pose_measured, 0.1, 0.005), (trace.pose_estimated, 0.1, 0.005)):
        errors = poses - trace.pose_true
        assert np.hypot(errors[:, 0], errors[:, 1]).max() < px
        assert np.abs(robsim.wrap_angle(errors[:, 2])).max() < rad

    # What it is: at every step, and from all of them at once.
    theta = sim.true_model.theta
    np.testing.assert_array_equal(trace.info.theta_true, theta)
    np.testing.assert_allclose(trace.parameters[-1], theta, atol=2e-3)
    np.testing.assert_allclose(robsim.batch_estimate(trace).batch, theta, atol=2e-3)

    # What is written down is the run, and gives it again.
    trace.save(tmp_path / "drive.npz")
    read = robsim.Trace.load(tmp_path / "drive.npz")
    assert read == trace
    with pytest.warns(UserWarning, match="estimate_state"):  # code is no data
        scenario = robsim.Scenario.of(read)
    kalman_filter = robsim.estimation.reference.ExtendedKalmanFilter()
    again = robsim.Simulation(scenario, estimate_state=kalman_filter)
    assert again.run(120).pose_estimated.tobytes() == trace.pose_estimated.tobytes()
