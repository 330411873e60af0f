"""The filters in a world whose inputs act late, and the pose for a controller there."""

import numpy as np
import pytest

import robsim
from robsim.estimation.reference import (
    ConstantVelocityKalmanFilter,
    ExtendedKalmanFilter,
    ParticleFilter,
    UnscentedKalmanFilter,
)

pytestmark = pytest.mark.kernels

ALL = [
    ExtendedKalmanFilter,
    pytest.param(UnscentedKalmanFilter, marks=pytest.mark.long),
    pytest.param(ParticleFilter, marks=pytest.mark.slow),
]
each_filter = pytest.mark.parametrize("kind", ALL)
DELAY = 2.4  # steps
NOISE = robsim.PoseNoise.from_sigma(0.1, 0.1, 0.003)
SEEN = np.array((0.3, 0.3, 0.01))  # px, px, rad


def late_run(seed, delay=DELAY, steps=100, process_noise=NOISE):
    """A run around an open area, whose inputs change in every step."""
    u = np.random.default_rng(seed).uniform(-0.5, 1.0, (steps, 2))
    return robsim.Simulation(
        control=robsim.Replay(u),
        motor_delay=delay,
        process_noise=process_noise,
        boundary="unlimited",
        seed=seed,
    ).run(steps)


def steps_of(trace, z):
    """The steps of a run, with these measured poses; a row of NaN = not seen."""
    last_u = np.vstack(((0, 0), trace.u[:-1]))
    return [
        robsim.Step(k=k, last_u=last_u[k], measurement=None if np.isnan(z[k, 0]) else z[k])
        for k in range(len(trace))
    ]


def measured(trace, sigma=SEEN, hidden=0.2, seed=7):
    rng = np.random.default_rng((seed, 1))
    z = trace.pose_true + rng.normal(size=(len(trace), 3)) * sigma
    z[1:][rng.random(len(z) - 1) < hidden] = np.nan
    return z


def mean_nees(kind, given, runs=8):
    """The mean NEES of some runs but for their first steps, and how far 5 standard errors go."""
    values = []
    for seed in range(runs):
        trace = late_run(seed)
        filter_ = kind(
            motor_delay=given,
            measurement_sigma=SEEN,
            process_sigma=NOISE.sigma,
        )
        estimates = [filter_(step) for step in steps_of(trace, measured(trace, seed=seed))]
        error = np.array([estimate.pose for estimate in estimates]) - trace.pose_true
        error[:, 2] = robsim.wrap_angle(error[:, 2])
        P = np.array([estimate.covariance for estimate in estimates])
        values.append(robsim.estimation.nees(error[20:], P[20:]).mean())
    return np.mean(values), 5 * np.std(values, ddof=1) / np.sqrt(runs)


@pytest.mark.long
@each_filter
def test_a_filter_that_knows_the_delay_is_consistent_and_one_that_does_not_is_not(kind):
    runs = 4 if kind is ParticleFilter else 8
    mean, margin = mean_nees(kind, DELAY, runs)
    assert abs(mean - 3) < margin < 3, mean
    mean, margin = mean_nees(kind, 0.0, runs)
    assert mean - margin > 4, mean


@pytest.mark.long
@pytest.mark.parametrize("delay", [0, 0.4, 3, 30.5])
def test_it_predicts_where_the_robot_is_when_an_input_begins_to_act(delay):
    trace = late_run(3, delay, process_noise=None)
    filter_ = ExtendedKalmanFilter(
        motor_delay=delay, process_sigma=(0, 0, 0), measurement_sigma=(1e-3, 1e-3, 1e-5)
    )
    ahead = []
    for step in steps_of(trace, measured(trace, 0)):
        estimate = filter_(step)
        np.testing.assert_allclose(estimate.pose[:2], trace.pose_true[step.k, :2], atol=0.02)
        ahead.append(filter_.predicted().pose)
    first, part = int(delay), delay % 1
    # from the first steps on, in which the velocity shows
    path = np.column_stack((trace.pose_true[:, :2], np.unwrap(trace.pose_true[:, 2])))
    at = (1 - part) * path[first:-1] + part * path[first + 1 :]
    error = np.array(ahead)[: len(at)] - at
    error[:, 2] = robsim.wrap_angle(error[:, 2])
    np.testing.assert_allclose(error[20:], 0, atol=0.01 + 0.2 * (part > 0))
    if delay > 1:
        now = np.abs(path[20 : len(at), :2] - at[20:, :2]).max()
        assert now > 10 * np.abs(error[20:, :2]).max()


@pytest.mark.long
@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter, ParticleFilter])
def test_looking_ahead_changes_nothing(kind):
    trace = late_run(1, steps=30)
    looking, other = kind(motor_delay=DELAY), kind(motor_delay=DELAY)
    for step in steps_of(trace, measured(trace)):
        estimate = looking(step)
        assert estimate == other(step)
        assert looking.predicted() == looking.predicted()
        assert looking.predicted() != estimate or step.k == 0


def test_without_a_delay_the_prediction_is_the_estimate():
    trace = late_run(1, 0, 10)
    for kind in (ExtendedKalmanFilter, UnscentedKalmanFilter, ParticleFilter):
        filter_ = kind()
        assert filter_.motor_delay == 0
        estimates = [filter_(step) for step in steps_of(trace, trace.pose_true)]
        assert filter_.predicted() == estimates[-1]


def test_lost_frames_are_steps_in_which_the_robot_was_not_seen():
    u = np.random.default_rng(2).uniform(-1, 1, (40, 2))
    gaps = [1, 1, 3, 1, 2, 4, 1, 1, 5]
    one, other = (ExtendedKalmanFilter(motor_delay=1.7) for _ in range(2))
    pose = (600.0, 500.0, 0.3)
    assert one(robsim.Step(k=0, measurement=pose)) == other(robsim.Step(k=0, measurement=pose))
    time = 0
    for k, gap in enumerate(gaps, 1):
        late = one(robsim.Step(k=k, dt=gap * 0.2, last_u=u[k], measurement=pose))
        for i in range(gap):
            time += 1
            seen = pose if i == gap - 1 else None
            prompt = other(robsim.Step(k=time, last_u=u[k], measurement=seen))
        np.testing.assert_allclose(late.pose, prompt.pose, rtol=1e-12)
        np.testing.assert_allclose(late.covariance, prompt.covariance, rtol=1e-9)
        np.testing.assert_allclose(one.predicted().pose, other.predicted().pose, rtol=1e-12)


def test_inputs_from_before_the_robot_is_seen_act_as_well():
    trace = late_run(4, 3, process_noise=None)
    z = measured(trace, 0, hidden=0)
    z[:30] = np.nan
    filter_ = ExtendedKalmanFilter(
        motor_delay=3, process_sigma=(0, 0, 0), measurement_sigma=(1e-3, 1e-3, 1e-5)
    )
    for step in steps_of(trace, z):
        estimate = filter_(step)
        if step.k == 29:
            assert filter_.predicted() == estimate  # the prior
    np.testing.assert_allclose(estimate.pose, trace.pose_true[-1], atol=1e-2)


def test_a_new_run_forgets_what_was_sent():
    trace = late_run(5, steps=20)
    steps = steps_of(trace, measured(trace))
    filter_ = ExtendedKalmanFilter(motor_delay=DELAY)
    first = [filter_(step) for step in steps]
    assert [filter_(step) for step in steps] == first


class LateRobot:
    """A robot of its own time, whose motors get each input late; it is asked for frames."""

    def __init__(self, delay):
        self.whole, self.part = int(delay), delay % 1
        self.k, self.u, self.sent = 0, np.zeros(2), [np.zeros(2)] * 10
        self.poses = [np.array((600, 600, 0.3))] * 2

    def send(self, u):
        self.u = np.array(u)

    def move(self):
        self.sent.append(self.u)
        newest, before = self.sent[-1 - self.whole], self.sent[-2 - self.whole]
        acting = (1 - self.part) * newest + self.part * before
        self.poses = [robsim.RobotModel().predict(*self.poses, acting), self.poses[0]]
        self.k += 1

    def frames(self):
        while True:
            pixels = np.zeros((120, 120, 3), np.uint8)
            yield robsim.Frame(pixels, t=0.2 * self.k)
            self.move()


@pytest.mark.parametrize("stopped", [0, 7])
def test_the_robot_is_stopped_in_between(stopped, rng):
    robot, innovations = LateRobot(DELAY), []
    filter_ = ExtendedKalmanFilter(
        motor_delay=DELAY, process_sigma=(0, 0, 0), measurement_sigma=(1e-3, 1e-3, 1e-5)
    )

    def estimate_state(step):
        estimate = filter_(step)
        innovations.append(np.abs(filter_.innovation).max())
        return estimate

    experiment = robsim.Experiment(
        robot.frames(),
        area=(120, 120),
        send=robot.send,
        measure=lambda step: robsim.Measurement(robot.poses[0]),
        estimate_state=estimate_state,
        control=lambda step: rng.uniform(-1, 1, 2),
    )
    experiment.run(15)
    for _ in range(stopped):
        robot.move()
    trace = experiment.run(15)
    np.testing.assert_array_equal(np.flatnonzero(trace.interrupted), [15])
    # Nothing is unknown: each pose is where the filter expects it, also after the stop.
    assert len(innovations) == 30
    np.testing.assert_allclose(innovations[3:], 0, atol=1e-8)


def drive(delay, compensated):
    """How far a robot with late motors strays from the line to its goal, and how it arrives."""
    sim = robsim.Simulation(
        measure=True,
        headings=None,
        resolution=(300, 300),
        start=(200, 600, 1.0),
        motor_delay=delay,
        seed=1,
    )
    filter_ = ExtendedKalmanFilter(
        sim.model, motor_delay=delay, measurement_sigma=(0.2, 0.2, 0.01), process_sigma=(0, 0, 0)
    )
    go = robsim.GoToPoint(900, 600, heading_gain=1.5)
    sim.estimate_state = filter_
    sim.control = (lambda step: go(filter_.ahead(step))) if compensated else go
    trace = sim.run(150)
    return np.abs(trace.pose_true[60:, 1] - 600).max(), trace


@pytest.mark.long
def test_a_controller_that_looks_ahead_drives_as_without_the_delay():
    prompt, _ = drive(0, compensated=False)
    late, _ = drive(4.5, compensated=False)
    compensated, trace = drive(4.5, compensated=True)
    assert late > 2 * compensated
    assert compensated < prompt + 15
    # the trace has the estimates for the frames, not those ahead
    assert np.abs((trace.pose_estimated - trace.pose_true)[40:, :2]).max() < 1


def test_the_step_ahead_has_what_the_step_had():
    filter_ = ExtendedKalmanFilter(motor_delay=1)
    step = robsim.Step(k=0, t=3.0, measurement=(1, 2, 0.5), last_u=(0.25, 0.5))
    filter_(step)
    ahead = filter_.ahead(step)
    assert ahead.estimate == filter_.predicted()
    assert (ahead.k, ahead.t, ahead.dt) == (step.k, step.t, step.dt)
    assert ahead.measurement == step.measurement
    np.testing.assert_array_equal(ahead.last_u, step.last_u)
    with pytest.raises(RuntimeError, match="step 1"):
        filter_.ahead(robsim.Step(k=1))


def test_the_delay_has_limits():
    for beyond in (-0.01, 1000.01):
        with pytest.raises(ValueError, match="motor_delay"):
            ExtendedKalmanFilter(motor_delay=beyond)
    assert ExtendedKalmanFilter(motor_delay=1000).motor_delay == 1000
    with pytest.raises(TypeError, match="motor_delay"):
        ConstantVelocityKalmanFilter(motor_delay=1)
