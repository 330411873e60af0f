"""Models of the robot: parameters, paths, the unicycle."""

import numpy as np
import pytest

import robsim
from robsim._core import path_sensitivities, simulated_path

# --- parameters


# The column "true value" of the manual's table, as printed there.
PRINTED = {
    "a1X": "1.9375", "a2X": "-0.9375", "b1X": "0.20833", "b2X": "0.20833", "d1X": "8.3333e-06",
    "a1Y": "1.9375", "a2Y": "-0.9375", "b1Y": "0.20833", "b2Y": "0.20833", "d1Y": "8.3333e-06",
    "a1P": "1.8333", "a2P": "-0.83333", "b1P": "0.030556", "b2P": "-0.030556", "d1P": "0",
}  # fmt: skip


def test_the_fifteen_true_values_of_the_manual():
    theta = robsim.RobotModel().theta
    values = dict(zip(robsim.trace.PARAMETER_NAMES, theta.ravel(), strict=True))
    assert {name: f"{value:.5g}" for name, value in values.items()} == PRINTED


def test_parameters_follow_the_physical_formulas():
    m, inertia, fv, fw, r, base, dt = 0.7, 0.2, 0.3, 0.4, 0.05, 0.2, 0.1
    alpha, beta = (0.04, 0.06), (1e-3, -2e-3)
    theta = robsim.RobotModel(
        robsim.RobotParameters(
            mass=m,
            inertia=inertia,
            linear_friction=fv,
            angular_friction=fw,
            wheel_radius=r,
            wheel_base=base,
            motor_gain=alpha,
            motor_offset=beta,
            dt=dt,
        )
    ).theta
    dx, dp = m / dt**2 + fv / dt, inertia / dt**2 + fw / dt
    lever = base / (2 * r)
    x = [(2 * m / dt**2 + fv / dt) / dx, -m / dt**2 / dx, alpha[0] / r / dx, alpha[1] / r / dx,
         sum(beta) / r / dx]  # fmt: skip
    p = [(2 * inertia / dt**2 + fw / dt) / dp, -inertia / dt**2 / dp, lever * alpha[0] / dp,
         -lever * alpha[1] / dp, lever * (beta[0] - beta[1]) / dp]  # fmt: skip
    np.testing.assert_allclose(theta, [x, x, p], rtol=1e-13)


def test_a_faster_left_wheel_turns_the_robot_to_the_right():
    # y points down, so that a right turn (clockwise in the picture) makes the heading grow.
    start = (600.0, 600.0, 0.0)
    x, y, heading = robsim.RobotModel().predict(start, start, (1.0, 0.0))
    assert heading > 0
    assert x > 600
    assert y == 600


def test_prediction_is_the_sum_of_regressors_times_theta(rng):
    model = robsim.RobotModel()
    poses = rng.uniform(-1, 1, (3, 3)) * (600, 600, 3)
    u = rng.uniform(-1, 1, (3, 2))
    phi, y = robsim.estimation.regression(poses, u)
    predicted = model.predict(poses[1], poses[0], u[1])
    expected = (phi[0] * model.theta).sum(axis=1)
    np.testing.assert_allclose(predicted[:2], expected[:2], rtol=1e-13)
    assert predicted[2] == pytest.approx(robsim.wrap_angle(expected[2]), abs=1e-12)
    np.testing.assert_allclose(y[0, :2], poses[2, :2])


def test_samples_never_see_a_wrapped_jump():
    heading = robsim.wrap_angle(np.linspace(0, 40, 200))
    poses = np.column_stack((np.zeros((200, 2)), heading))
    phi, y = robsim.estimation.regression(poses, np.zeros((200, 2)))
    steps = np.column_stack((phi[:, 2, 0] - phi[:, 2, 1], y[:, 2] - phi[:, 2, 0]))
    np.testing.assert_allclose(steps, 40 / 199, rtol=1e-9)


def test_spin_turns_by_105_hundredths_of_a_degree_a_step():
    trace = robsim.Simulation().run(200)
    turned = np.rad2deg(robsim.wrap_angle(np.diff(trace.pose_true[100:, 2])))
    np.testing.assert_allclose(turned, 1.05, atol=0.001)


# --- many steps at once


def test_many_predictions_are_those_of_single_steps(rng):
    model = robsim.RobotModel()
    pose_1, pose_2 = rng.uniform(-4, 4, (2, 20, 3))
    u = rng.uniform(-1, 1, (20, 2))
    one_by_one = [model.predict(*step) for step in zip(pose_1, pose_2, u, strict=True)]
    np.testing.assert_array_equal(model.predict(pose_1, pose_2, u), one_by_one)


def test_one_row_stands_for_all(rng):
    model = robsim.RobotModel()
    for single in range(3):
        many = [*rng.uniform(-1, 1, (2, 5, 3)), rng.uniform(-1, 1, (5, 2))]
        given = [rows[0] if i == single else rows for i, rows in enumerate(many)]
        many[single] = np.tile(many[single][0], (5, 1))
        np.testing.assert_array_equal(model.predict(*given), model.predict(*many))
        np.testing.assert_array_equal(model.jacobian(*given), model.jacobian(*many))


def test_no_rows_give_none():
    model = robsim.RobotModel()
    none = np.empty((0, 3))
    assert model.predict(none, none, (0, 0)).shape == (0, 3)
    assert model.jacobian(none, none, (0, 0)).shape == (0, 3, 6)


def test_unwrapped_headings_stay_unwrapped():
    model = robsim.RobotModel()
    pose_1, pose_2, u = np.array((1, 2, 9.3)), np.array((1, 2, 9.5)), (0.1, -0.2)
    unwrapped = model.predict(pose_1, pose_2, u, unwrapped=True)
    assert 9.0 < unwrapped[2] < 9.3
    wrapped = model.predict(pose_1, pose_2, u)
    np.testing.assert_allclose(wrapped[:2], unwrapped[:2], rtol=1e-12)
    assert wrapped[2] == pytest.approx(robsim.wrap_angle(unwrapped[2]), abs=1e-12)


def test_the_jacobian_is_the_derivative_of_the_prediction(rng):
    model = robsim.RobotModel()
    poses, u = rng.uniform(-3, 3, 6), rng.uniform(-1, 1, 2)
    step = 1e-6
    expected = np.empty((3, 6))
    for i, moved in enumerate(np.eye(6) * step):
        after, before = (
            model.predict(*np.split(poses + change, 2), u, unwrapped=True)
            for change in (moved, -moved)
        )
        expected[:, i] = (after - before) / (2 * step)
    np.testing.assert_allclose(model.jacobian(*np.split(poses, 2), u), expected, atol=1e-8)


def test_the_steps_in_a_time():
    model = robsim.RobotModel()
    for dt, steps in ((0.2, 1), (0.249, 1), (0.16, 1), (0.4, 2), (60, 300)):
        assert model.steps_in(dt) == steps
    for dt in (0.0333, 0.1, 0.27, 0, -0.2, np.inf, 1e300):
        with pytest.raises(ValueError, match=r"\bdt\b"):
            model.steps_in(dt)


# --- limits

THETA = robsim.RobotModel().theta


def with_entry(row, column, value):
    theta = np.array(THETA)
    theta[row, column] = value
    return theta


def test_parameters_out_of_range_are_refused():
    tiny = 5e-324
    for names, values in (
        ("mass inertia wheel_radius wheel_base dt", (0, -1, np.inf)),
        ("linear_friction angular_friction", (-tiny, np.inf)),
        ("motor_gain motor_offset", ((1,), (1, 2, 3), (np.nan, 1), {1, 2})),
    ):
        for name in names.split():
            for value in values:
                with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                    robsim.RobotParameters(**{name: value})
    robsim.RobotParameters(linear_friction=0, angular_friction=0)


def test_a_model_is_stable():
    for name, value, entry in (
        ("linear_friction", 0.0, "a1X"),
        ("angular_friction", 0.0, "a1P"),
        ("mass", 1e20, "a1X"),
        ("dt", 1e308, ""),
        ("wheel_radius", 5e-324, ""),
        ("motor_gain", (1e308, 0), ""),
    ):
        with pytest.raises(ValueError, match=rf"{entry}.*\b{name}\b"):
            robsim.RobotModel(robsim.RobotParameters(**{name: value}))
    for row, axis in enumerate("XYP"):
        for a1 in (0.0, 2.0, -0.5, 2.5):
            with pytest.raises(ValueError, match=rf"\ba1{axis}\b"):
                robsim.RobotModel.from_theta(with_entry(row, 0, a1))
    for name, theta in (
        ("a2X", with_entry(0, 1, 50)),
        ("theta", with_entry(1, 2, np.inf)),
        ("theta", THETA.T),
        ("theta", THETA[None]),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            robsim.RobotModel.from_theta(theta)
    for dt in (0, -1, np.inf):
        with pytest.raises(ValueError, match=r"\bdt\b"):
            robsim.RobotModel.from_theta(THETA, dt=dt)


def test_poses_and_inputs_of_other_shapes_are_refused():
    model, pose, u = robsim.RobotModel(), (1, 2, 3), (0, 0)
    for call in (model.predict, model.jacobian):
        for wrong in ((1, 2), (1, 2, 3, 4), [[1, 2]], [[[1, 2, 3]]], (np.nan, 0, 0), ()):
            with pytest.raises(ValueError, match="pose_1"):
                call(wrong, pose, u)
            with pytest.raises(ValueError, match="pose_2"):
                call(pose, wrong, u)
        for wrong in ((1,), (1, 2, 3), (np.nan, 1), [[[1, 2]]]):
            with pytest.raises(ValueError, match=r"\bu\b"):
                call(pose, pose, wrong)
        with pytest.raises(ValueError, match=r"\bu\b"):
            call([pose] * 3, pose, [u] * 2)


# --- paths


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


# --- the unicycle


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
