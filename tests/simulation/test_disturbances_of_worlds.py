"""Process noise, parameter mismatch and delays of the simulated world."""

import numpy as np
import pytest

import robsim
from robsim import Dropout, GaussianNoise, ParameterMismatch, PoseNoise, Simulation, WheelNoise

STEPS = 4000
SMALL = {"resolution": (240, 240), "boundary": "unlimited"}


def prediction_errors(trace, model):
    """Return the pose minus what the model predicts from the two before, (N - 2, 3)."""
    poses = trace.pose_true
    errors = poses[2:] - model.predict(poses[1:-1], poses[:-2], trace.u[1:-1])
    errors[:, 2] = robsim.wrap_angle(errors[:, 2])
    return errors


def mean_square(errors, Q):
    """Return the mean of e' Q^-1 e, which is 3 for errors of covariance Q."""
    return np.einsum("ki,ij,kj->k", errors, np.linalg.inv(Q), errors).mean()


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_pose_noise_has_the_covariance_that_was_given(rng, rho):
    Q = np.array([[0.25, rho * 0.2, 0], [rho * 0.2, 0.16, 0.001], [0, 0.001, 1e-4]])
    noise = PoseNoise(Q)
    sim = Simulation(seed=int(rng.integers(2**32)), process_noise=noise, **SMALL)
    errors = prediction_errors(sim.run(STEPS), sim.model)
    # 3 +- 5 standard deviations of a mean of so many chi-square numbers with 3 degrees of freedom
    assert mean_square(errors, noise.Q) == pytest.approx(3, abs=5 * np.sqrt(6 / STEPS))
    np.testing.assert_allclose(noise.factor @ noise.factor.T, Q, atol=1e-15)
    shifted = np.corrcoef(errors[1:, 0], errors[:-1, 0])[0, 1]
    assert abs(shifted) < 5 / np.sqrt(STEPS)


def test_a_singular_covariance_disturbs_only_where_it_says():
    sim = Simulation(seed=1, process_noise=PoseNoise.from_sigma(0.5, 0, 0), **SMALL)
    errors = prediction_errors(sim.run(200), sim.model)
    assert errors[:, 0].std() == pytest.approx(0.5, rel=0.3)
    np.testing.assert_allclose(errors[:, 1:], 0, atol=1e-9)


@pytest.mark.parametrize("motor", [0, 1])
def test_the_noise_of_one_motor_alone_turns_the_robot(motor):
    sim = Simulation(seed=1, process_noise=WheelNoise(np.eye(2)[motor]), **SMALL)
    trace = sim.run(20)
    # error of the heading = biP times what was added to u_i
    disturbance = prediction_errors(trace, sim.model)[:, 2] / sim.model.theta[2, 2 + motor]
    assert 0.5 < disturbance.std() < 2


@pytest.mark.long
def test_wheel_noise_moves_the_pose_as_its_covariance_says(rng):
    noise = WheelNoise((0.05, 0.1))
    sim = Simulation(
        seed=int(rng.integers(2**32)),
        process_noise=noise,
        control=robsim.DriveAround(),
        **SMALL,
    )
    trace = sim.run(STEPS)
    errors = prediction_errors(trace, sim.model)
    along = [noise.Q(sim.model, heading) for heading in trace.pose_true[1:-1, 2]]
    measured = errors.T @ errors / len(errors)
    np.testing.assert_allclose(measured[2, 2], np.mean([Q[2, 2] for Q in along]), rtol=0.15)
    np.testing.assert_allclose(np.trace(measured), np.mean([np.trace(Q) for Q in along]), rtol=0.15)


def test_the_streams_do_not_disturb_each_other():
    options = {"seed": 5, "control": robsim.DriveAround(), "process_noise": WheelNoise(0.1)}
    path = Simulation(**options).run(50).pose_true
    noisy = Simulation(
        **options, noise=GaussianNoise(10), dropout=Dropout(0.5), resolution=(120, 120)
    )
    np.testing.assert_array_equal(noisy.run(50).pose_true, path)
    assert (Simulation(**{**options, "seed": 6}).run(50).pose_true != path).any()
    undisturbed = Simulation(**{**options, "process_noise": None}).run(50)
    assert (undisturbed.pose_true[2:] != path[2:]).any(axis=1).all()
    np.testing.assert_array_equal(undisturbed.u, Simulation(**options).run(50).u)


def test_the_robot_stands_at_the_start_in_step_0():
    start = (200.0, 300.0, 0.5)
    for noise in (None, PoseNoise.from_sigma(5, 5, 0.1)):
        trace = Simulation(start=start, process_noise=noise, seed=1).run(2)
        np.testing.assert_array_equal(trace.pose_true[0], start)
        assert not trace.bounced[0]


def test_the_parameters_of_the_world_differ_from_those_that_the_robot_believes_in():
    sim = Simulation(mismatch=ParameterMismatch(0.1), seed=3, control=robsim.DriveAround(), **SMALL)
    trace = sim.run(300)
    np.testing.assert_array_equal(sim.model.theta, robsim.RobotModel().theta)
    assert (sim.true_model.theta[:, 0] != sim.model.theta[:, 0]).all()
    np.testing.assert_array_equal(trace.info.theta_true, sim.true_model.theta)
    np.testing.assert_allclose(prediction_errors(trace, sim.true_model), 0, atol=1e-9)
    again = Simulation(mismatch=ParameterMismatch(0.1), seed=3)
    np.testing.assert_array_equal(again.true_model.theta, sim.true_model.theta)
    found = robsim.batch_estimate(trace, identify_from="truth").batch
    np.testing.assert_allclose(found, sim.true_model.theta, atol=1e-5)


def test_the_model_is_an_option_and_a_slot():
    heavy = robsim.RobotParameters(mass=0.6)
    by_option = Simulation(model=heavy)
    np.testing.assert_array_equal(by_option.model.theta, robsim.RobotModel(heavy).theta)
    np.testing.assert_array_equal(by_option.true_model.theta, by_option.model.theta)
    by_slot = Simulation(define_model=lambda: robsim.RobotModel(heavy))
    assert by_slot.run(20).pose_true.tobytes() == by_option.run(20).pose_true.tobytes()
    assert by_slot.trace.info.callbacks == ("define_model",)
    assert by_option.trace.info.callbacks == ()


def test_the_motors_get_their_inputs_late():
    u = robsim.Simulation(control=robsim.DriveAround(), seed=1).run(30).u
    prompt = Simulation(control=robsim.Replay(u)).run(30).pose_true
    late = Simulation(control=robsim.Replay(u), motor_delay=3).run(30)
    np.testing.assert_array_equal(late.u, u)
    model = robsim.RobotModel()
    at_rest = model.predict(late.pose_true[0], late.pose_true[0], (0, 0))
    np.testing.assert_array_equal(late.pose_true[1], at_rest)
    # Until the first input arrives only the offset of the motors moves the robot.
    np.testing.assert_allclose(late.pose_true[4:], prompt[1:-3], atol=1e-3)
    assert np.abs(late.pose_true[4:] - prompt[4:]).max() > 1


def acting(u, k, delay):
    """Return the mean of what acts from step k to k + 1, each input from `delay` steps on."""
    total = np.zeros(2)
    for step, given in enumerate(u):
        # the input of a step acts from step + delay to step + delay + 1
        overlap = min(k + 1, step + delay + 1) - max(k, step + delay)
        total = total + max(overlap, 0.0) * given
    return total


@pytest.mark.parametrize("delay", [0, 1, 3, 0.25, 2.4, 700.125])
def test_the_motors_get_the_mean_of_the_inputs_that_act_in_a_step(delay):
    got = []

    def evaluate_model(world):
        got.append(world.last_u)
        return world.model.predict(world.pose_1, world.pose_2, world.last_u)

    options = {"control": robsim.DriveAround(), "seed": 1, "motor_delay": delay}
    trace = Simulation(evaluate_model=evaluate_model, **options).run(40)
    expected = [acting(trace.u, k, delay) for k in range(39)]
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)
    assert Simulation(**options).run(40).pose_true.tobytes() == trace.pose_true.tobytes()


def test_a_delay_of_whole_steps_is_one_however_it_is_written():
    for delay in (2, 2.0, np.int8(2)):
        assert type(robsim.Scenario(motor_delay=delay).motor_delay) is int
        assert type(robsim.Scenario(motor_delay=delay + 0.5).motor_delay) is float


@pytest.mark.long
def test_the_frames_come_late_and_say_when_they_were_taken():
    options = {"control": robsim.DriveAround(), "measure": True, "headings": None, "seed": 2}
    options |= {"resolution": (600, 600)}
    prompt = Simulation(**options)
    late = Simulation(**options, camera_delay=2, noise=GaussianNoise(5), dropout=Dropout(0.3))
    expected, seen = prompt.run(12), []
    frames = []

    @late.estimate_state
    def estimate_state(step):
        seen.append((step.t, step.frame and step.frame.t, step.measurement is not None))
        frames.append(step.frame and step.frame.image.copy())
        return robsim.Estimate((0, 0, 0), np.eye(3))

    trace = late.run(12)
    np.testing.assert_array_equal(trace.pose_true, expected.pose_true)
    assert [frame_t for _, frame_t, _ in seen[:2]] == [None, None]
    np.testing.assert_allclose([t - frame_t for t, frame_t, _ in seen[2:]], 0.4)
    assert not trace.seen[:2].any()
    assert trace.seen[2:].any()
    errors = (trace.pose_measured[2:] - trace.pose_true[:-2])[trace.seen[2:]]
    assert np.abs(errors[:, :2]).max() < 3
    for k in range(2, 12):
        np.testing.assert_array_equal(late.render_step(k).image, frames[k])
    with pytest.raises(IndexError, match="step 1: camera_delay is 2"):
        late.render_step(1)


def test_before_the_first_frame_there_is_none():
    late = Simulation(camera_delay=1, resolution=(120, 120))
    with pytest.raises(RuntimeError, match="no frame"):
        late.frame  # noqa: B018
    late.run(2)
    assert late.frame.index == 0


def test_noise_and_dropout_change_between_steps_and_the_past_is_drawn_as_it_was():
    sim = Simulation(seed=4, resolution=(250, 250), measure=True)
    images = []

    def run(steps):
        for _ in range(steps):
            images.append(sim.step().frame.image.copy())

    run(3)
    sim.noise = GaussianNoise(20)
    run(3)
    sim.noise, sim.dropout = robsim.UniformNoise(8), Dropout(1.0)
    run(2)
    sim.noise = sim.dropout = None
    run(2)
    trace = sim.trace
    np.testing.assert_array_equal(trace.noise[:, 0], [0] * 3 + [20] * 3 + [0] * 4)
    np.testing.assert_array_equal(trace.noise[:, 1], [0] * 6 + [8] * 2 + [0] * 2)
    np.testing.assert_array_equal(trace.hidden, [False] * 6 + [True] * 2 + [False] * 2)
    for k, image in enumerate(images):
        np.testing.assert_array_equal(sim.render_step(k).image, image)
    assert sim.scenario.noise is None
    for name in ("noise", "dropout", "process_noise"):
        with pytest.raises(TypeError, match=rf"\b{name}\b"):
            setattr(sim, name, 0.5)


def test_process_noise_changes_between_steps_from_a_callback_too():
    sim = Simulation(seed=4, **SMALL)

    @sim.control
    def control(step):
        if step.k == 10:
            sim.process_noise = PoseNoise.from_sigma(1, 1, 0.01)
        return 0.1, 0.1

    errors = prediction_errors(sim.run(20), sim.model)
    np.testing.assert_allclose(errors[:9], 0, atol=1e-9)
    assert np.abs(errors[9:, 0]).min() > 1e-4
