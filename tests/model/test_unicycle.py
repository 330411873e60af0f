import numpy as np

import robsim

U = np.random.default_rng(8).uniform(-0.3, 1.0, (60, 2))


def drive(evaluate_model, u=U, **options):
    return robsim.Simulation(
        evaluate_model=evaluate_model,
        control=lambda step: u[step.k],
        boundary="unlimited",
        **options,
    ).run(len(u))


def test_it_follows_the_equations_step_by_step():
    poses = drive(robsim.Unicycle()).pose_true
    theta = robsim.RobotModel().theta
    for k in range(2, len(poses)):
        before, last, now = poses[k - 2], poses[k - 1], poses[k]
        direction = np.array([np.cos(before[2]), np.sin(before[2])])
        way = -theta[0, 1] * (last - before)[:2] @ direction
        way += theta[0, 2:4] @ U[k - 1] + theta[0, 4]
        expected = last[:2] + way * np.array([np.cos(last[2]), np.sin(last[2])])
        np.testing.assert_allclose(now[:2], expected, rtol=0, atol=1e-9)


def test_it_moves_along_its_heading_only_and_the_robot_model_does_not():
    def side_slip(poses):
        steps, headings = np.diff(poses[:, :2], axis=0), poses[:-1, 2]
        return np.abs(steps[:, 1] * np.cos(headings) - steps[:, 0] * np.sin(headings)).max()

    assert side_slip(drive(robsim.Unicycle()).pose_true) < 1e-9
    assert side_slip(drive(None).pose_true) > 0.3


def test_heading_and_straight_lines_are_those_of_the_robot_model():
    np.testing.assert_array_equal(
        drive(robsim.Unicycle()).pose_true[:, 2], drive(None).pose_true[:, 2]
    )
    straight = np.repeat(U[:, :1], 2, axis=1)
    start = (600, 600, 0.7)
    np.testing.assert_allclose(
        drive(robsim.Unicycle(), straight, start=start).pose_true,
        drive(None, straight, start=start).pose_true,
        rtol=0,
        atol=1e-8,
    )


def test_native_and_called_from_python_give_the_same():
    unicycle = robsim.Unicycle()
    native, called = drive(unicycle), drive(lambda world: unicycle(world))
    np.testing.assert_array_equal(native.pose_true, called.pose_true)


def test_the_wrong_model_shows_in_the_identification():
    trace = {
        model: robsim.Simulation(
            evaluate_model=model, control=robsim.DriveAround(), boundary="unlimited", seed=4
        ).run(800)
        for model in (None, robsim.Unicycle())
    }
    right, wrong = (robsim.batch_estimate(run) for run in trace.values())
    assert (right.residual_rms < 1e-9).all()
    assert (wrong.residual_rms[:2] > 0.1).all()
    assert wrong.residual_rms[2] < 1e-9
    assert abs(wrong.batch[0, 0] - wrong.theta_true[0, 0]) > 0.01


def test_only_an_exact_unicycle_goes_native():
    class Half(robsim.Unicycle):
        def __call__(self, world):
            return (world.pose_1 + super().__call__(world)) / 2

    assert (drive(Half()).pose_true[-1] != drive(robsim.Unicycle()).pose_true[-1]).any()
