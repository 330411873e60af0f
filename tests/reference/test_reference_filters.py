import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from robsim.reference import (
    ConstantVelocityKalmanFilter,
    ExtendedKalmanFilter,
    ParticleFilter,
    Prior,
    RobotMotion,
    UnscentedKalmanFilter,
)

pytestmark = pytest.mark.kernels

DT = 0.2
KALMAN = [ConstantVelocityKalmanFilter, ExtendedKalmanFilter, UnscentedKalmanFilter]
ON_THE_MODEL = [ExtendedKalmanFilter, UnscentedKalmanFilter, ParticleFilter]
ALL = [*KALMAN, ParticleFilter]
CONTINUOUS = {"process_sigma": (0.02, 0.02, 0.001)}
PRIOR = Prior(pose=(3, -2, 0.4), pose_sigma=(5, 4, 0.5), velocity_sigma=(2, 3, 0.2))

# A robot that an input only turns: its model is linear in the state.
LINEAR = robsim.RobotModel.from_theta(
    [[1.9, -0.9, 0, 0, 0], [1.8, -0.8, 0, 0, 0.0], [1.7, -0.7, 0.03, -0.02, 0.001]]
)


def step_of(k, pose=None, u=(0, 0), dt=DT):
    measurement = robsim.Measurement(pose) if isinstance(pose, np.ndarray | tuple | list) else pose
    return SimpleNamespace(k=k, t=k * dt, dt=dt, last_u=np.array(u, float), measurement=measurement)


def filtered(estimate_state, z, u=None, *, R=None, **options):
    """Poses, covariances and velocities that a filter gives; a row of NaN in z = not seen.

    R are the covariances of the measurements, if they say them.
    """
    u = np.zeros((len(z), 2)) if u is None else u

    def measurement(k):
        if np.isnan(z[k, 0]):
            return None
        return z[k] if R is None else robsim.Measurement(z[k], covariance=R[k])

    estimates = [estimate_state(step_of(k, measurement(k), u[k], **options)) for k in range(len(z))]
    return tuple(
        np.array([getattr(estimate, name) for estimate in estimates])
        for name in ("pose", "covariance", "state")
    )


def error_of(poses, truth):
    error = poses - truth
    error[..., 2] = robsim.wrap_angle(error[..., 2])
    return error


def rms(errors):
    return np.sqrt(np.mean(errors**2, axis=0))


def random_inputs(rng, steps):
    """Voltages as the filter sees them: the input of the step before, held for 10 steps."""
    return np.repeat(rng.uniform(-0.5, 1.5, (steps // 10 + 1, 2)), 10, axis=0)[:steps]


# --- a linear problem: the plain Kalman filter of one axis


def plain_kalman_filter(z, F, Q, P, x, R, push):
    """Mean and variance of the first of two states that z measures; the textbook's five lines."""
    means, variances = [], []
    for k in range(len(z)):
        if k > 0:
            x = F @ x + push[k]
            P = F @ P @ F.T + Q
        if not np.isnan(z[k]):
            K = P[:, 0] / (P[0, 0] + R)
            x = x + K * (z[k] - x[0])
            P = P - np.outer(K, P[0])
        means.append(x[0])
        variances.append(P[0, 0])
    return np.array(means), np.array(variances)


NOISES = {"process_sigma": (0.3, 0.2, 0.02), "measurement_sigma": (0.5, 0.7, 0.03)}


def linear_problem(rng, steps=80):
    """Measured poses of LINEAR with dropouts, away from the seam of the heading, and inputs."""
    motion, u = RobotMotion(LINEAR), rng.uniform(-0.2, 0.2, (steps, 2))
    states = np.empty((steps, 6))
    states[0] = rng.multivariate_normal(PRIOR.mean, PRIOR.P)
    for k in range(1, steps):
        noise = rng.normal(0, NOISES["process_sigma"])
        states[k] = motion.move(states[k - 1], u[k]) + motion.G @ noise
    z = states[:, :3] + rng.normal(0, NOISES["measurement_sigma"], (steps, 3))
    assert np.abs(z[:, 2]).max() < 3
    z[1:][rng.random(steps - 1) < 0.2] = np.nan
    return z, u


def model_axis(axis, z, u, process_sigma, measurement_sigma):
    """The oracle for an axis of LINEAR; its states are the last two places."""
    a1, a2, b1, b2, d1 = LINEAR.theta[axis]
    place = PRIOR.pose_sigma[axis] ** 2
    before = place + (DT * PRIOR.velocity_sigma[axis]) ** 2
    push = np.zeros((len(z), 2))
    push[:, 0] = b1 * u[:, 0] + b2 * u[:, 1] + (d1 if axis == 2 else 0)
    return plain_kalman_filter(
        z[:, axis],
        F=np.array([[a1, a2], [1, 0]]),
        Q=np.diag([process_sigma[axis] ** 2, 0]),
        P=np.array([[place, place], [place, before]]),
        x=np.full(2, float(PRIOR.pose[axis])),
        R=measurement_sigma[axis] ** 2,
        push=push,
    )


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter])
def test_on_a_linear_model_it_is_the_plain_kalman_filter(kind, rng):
    z, u = linear_problem(rng)
    poses, covariances, _ = filtered(kind(LINEAR, prior=PRIOR, **NOISES), z, u)
    for axis in range(3):
        mean, variance = model_axis(axis, z, u, **NOISES)
        np.testing.assert_allclose(poses[:, axis], mean, rtol=0, atol=1e-10)
        np.testing.assert_allclose(covariances[:, axis, axis], variance, rtol=1e-10)


def test_how_far_out_the_points_are_changes_nothing_there(rng):
    z, u = linear_problem(rng)
    poses = [filtered(UnscentedKalmanFilter(LINEAR, kappa=k), z, u)[0] for k in (0, 7.5)]
    np.testing.assert_allclose(*poses, rtol=0, atol=1e-9)


def test_the_constant_velocity_filter_is_the_plain_kalman_filter(rng):
    z, _ = linear_problem(rng)
    acceleration_sigma, measurement_sigma = (8, 6, 0.7), (0.5, 0.7, 0.03)
    poses, covariances, _ = filtered(
        ConstantVelocityKalmanFilter(
            acceleration_sigma=acceleration_sigma, measurement_sigma=measurement_sigma, prior=PRIOR
        ),
        z,
        dt=0.1,
    )
    for axis in range(3):
        gain = np.array([0.1**2 / 2, 0.1]) * acceleration_sigma[axis]
        mean, variance = plain_kalman_filter(
            z[:, axis],
            F=np.array([[1, 0.1], [0, 1]]),
            Q=np.outer(gain, gain),
            P=np.diag([PRIOR.pose_sigma[axis] ** 2, PRIOR.velocity_sigma[axis] ** 2]),
            x=np.array([PRIOR.pose[axis], 0.0]),
            R=measurement_sigma[axis] ** 2,
            push=np.zeros((len(z), 2)),
        )
        np.testing.assert_allclose(poses[:, axis], mean, rtol=0, atol=1e-10)
        np.testing.assert_allclose(covariances[:, axis, axis], variance, rtol=1e-10)


@pytest.mark.long
def test_the_particle_filter_is_the_plain_kalman_filter_but_for_chance(rng):
    z, u = linear_problem(rng, steps=40)
    particles = ParticleFilter(LINEAR, n_particles=20_000, prior=PRIOR, **NOISES)
    poses, covariances, _ = filtered(particles, z, u)
    by_axis = [model_axis(axis, z, u, **NOISES) for axis in range(3)]
    mean, variance = np.moveaxis(np.array(by_axis), 0, -1)
    # thousands of effective particles: mean and variance are right within a few hundredths
    assert rms(((poses - mean) / np.sqrt(variance)).ravel()) < 0.07
    ratio = np.diagonal(covariances, axis1=1, axis2=2) / variance
    assert rms(ratio.ravel() - 1) < 0.07


# --- the robot model in state space


def test_it_moves_as_the_model_predicts(rng):
    motion, model = RobotMotion(), robsim.RobotModel()
    for _ in range(20):
        last, before = rng.uniform((-500, -500, -3), (500, 500, 3), (2, 3))
        u = rng.uniform(-1, 1, 2)
        turned = robsim.wrap_angle(last[2] - before[2])
        velocity = np.array([*(last - before)[:2], turned]) / DT
        state = motion.move(np.concatenate((last, velocity)), u)
        pose = model.predict(last, before, u)
        np.testing.assert_allclose(error_of(state[:3], pose), 0, atol=1e-9)
        np.testing.assert_allclose(state[3:], (state[:3] - last) / DT, atol=1e-9)


def test_many_states_move_as_each_of_them(rng):
    states, u = rng.normal(size=(7, 6)), rng.normal(size=2)
    each = [RobotMotion().move(state, u) for state in states]
    np.testing.assert_array_equal(RobotMotion().move(states, u), each)


def test_the_jacobian_is_what_finite_differences_say(rng):
    for model in (robsim.RobotModel(), LINEAR):
        motion = RobotMotion(model)
        state, u = rng.normal(0, (50, 50, 2, 10, 10, 1)), rng.uniform(-1, 1, 2)
        # (f(x + h) - f(x - h)) / 2h
        steps = 1e-4 * np.eye(6)
        columns = motion.move(state + steps, u) - motion.move(state - steps, u)
        np.testing.assert_allclose(motion.jacobian(state, u), columns.T / 2e-4, atol=1e-7)


def test_the_model_is_that_of_the_run():
    quick = robsim.RobotModel(robsim.RobotParameters(dt=0.1))
    filtered(ExtendedKalmanFilter(quick), np.zeros((3, 3)), dt=0.1)
    with pytest.raises(ValueError, match=r"step\.dt"):
        filtered(ExtendedKalmanFilter(), np.zeros((3, 3)), dt=0.1)
    with pytest.raises(ValueError, match=r"step\.dt"):
        filtered(ParticleFilter(), np.zeros((3, 3)), dt=0.27)


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter])
def test_lost_frames_are_as_many_steps_unseen(kind):
    hidden, late = kind(), kind()
    for k, pose in enumerate([(600, 600, 0), (601, 600, 0.01)]):
        hidden(step_of(k, pose, (1, 0.5)))
        late(step_of(k, pose, (1, 0.5)))
    hidden(step_of(2, u=(1, 0.5)))
    hidden(step_of(3, u=(1, 0.5)))
    expected = hidden(step_of(4, (602, 600, 0.1), (1, 0.5)))
    estimate = late(step_of(2, (602, 600, 0.1), (1, 0.5), dt=3 * DT + 0.01))
    np.testing.assert_array_equal(estimate.pose, expected.pose)
    np.testing.assert_array_equal(estimate.covariance, expected.covariance)


# --- statistics


def simulated_run(rng, steps, process_sigma, measurement_sigma):
    """True states, measured poses and inputs of a robot with noise in its equations."""
    motion = RobotMotion()
    states, u = np.empty((steps, 6)), random_inputs(rng, steps)
    states[0] = rng.normal((600, 600, 0, 0, 0, 0), (100, 100, 1.8, 15, 15, 0.3))
    for k in range(1, steps):
        states[k] = motion.move(states[k - 1], u[k]) + motion.G @ rng.normal(0, process_sigma)
    return states, states[:, :3] + rng.normal(0, measurement_sigma, (steps, 3)), u


RUNS = 20
# 2.5 % and 97.5 % points of chi-square with 6 RUNS = 120 degrees of freedom, over RUNS
BAND = np.array([91.573, 152.211]) / RUNS
TRUE_NOISES = {"process_sigma": (0.1, 0.1, 0.005), "measurement_sigma": (0.4, 0.4, 0.05)}


def share_in_band(kind, rng, steps=100, **assumed):
    """Share of the steps at which the NEES, averaged over the runs, is within its 95 % band."""
    nees = np.zeros(steps)
    for _ in range(RUNS):
        states, z, u = simulated_run(rng, steps, **TRUE_NOISES)
        estimate_state = kind(**(TRUE_NOISES | assumed))
        for k in range(steps):
            estimate_state(step_of(k, z[k], u[k]))
            error = error_of(estimate_state.mean, states[k])
            nees[k] += error @ np.linalg.solve(estimate_state.P, error) / RUNS
    return np.mean((BAND[0] < nees) & (nees < BAND[1]))


@pytest.mark.long
@pytest.mark.parametrize(
    "kind", [*ON_THE_MODEL[:2], pytest.param(ParticleFilter, marks=pytest.mark.slow)]
)
def test_the_covariance_is_honest(kind, rng):
    assert share_in_band(kind, rng, 40 if kind is ParticleFilter else 100) >= 0.8


@pytest.mark.long
def test_the_innovation_is_as_large_as_its_covariance_says(rng):
    nis = []
    _, z, u = simulated_run(rng, 1000, **TRUE_NOISES)
    kalman = ExtendedKalmanFilter(**TRUE_NOISES)
    for k in range(len(z)):
        kalman(step_of(k, z[k], u[k]))
        nis.append(kalman.innovation @ np.linalg.solve(kalman.S, kalman.innovation))
    # chi-square with 3 degrees of freedom: mean 3, standard deviation sqrt(6)
    assert np.mean(nis[1:]) == pytest.approx(3, abs=3 * np.sqrt(6 / len(nis)))
    assert kalman(step_of(len(z))) is not None
    assert (kalman.innovation, kalman.S) == (None, None)


# --- the process noise of a simulation


class OnWheels(ExtendedKalmanFilter):
    """The extended filter with the covariance of noise on the wheels, at the estimated heading."""

    noise = robsim.WheelNoise((0.2, 0.3))

    def predict(self, u, dt):
        self.Q = self.noise.Q(self.motion.model, self.mean[2])
        super().predict(u, dt)


POSE_NOISE = robsim.PoseNoise.from_sigma(0.3, 0.2, 0.01)
CORRELATED = robsim.PoseNoise([[0.09, 0.05, 0], [0.05, 0.04, 0], [0, 0, 1e-4]])


def in_world_with(process_noise, rng, make, runs=RUNS):
    """How consistent a filter is in a simulation with a process noise, and ideal measurements."""
    traces = [
        robsim.Simulation(
            boundary="unlimited",
            control=robsim.DriveAround(),
            process_noise=process_noise,
            seed=int(rng.integers(2**31)),
        ).run(100)
        for _ in range(runs)
    ]
    errors, covariances = [], []
    for trace in traces:
        z = trace.pose_true + rng.normal(0, (0.4, 0.4, 0.02), (100, 3))
        poses, P, _ = filtered(make(), z, inputs_before(trace))
        errors.append(error_of(poses, trace.pose_true)[10:])  # after the prior is forgotten
        covariances.append(P[10:])
    return robsim.evaluation.nees_consistency(np.array(errors), np.array(covariances))


R = {"measurement_sigma": (0.4, 0.4, 0.02)}


def with_covariance(kind, Q):
    made = kind(**R)
    made.Q = Q
    return made


@pytest.mark.long
@pytest.mark.parametrize(
    ("process_noise", "make"),
    [
        (POSE_NOISE, lambda: ExtendedKalmanFilter(process_sigma=POSE_NOISE.sigma, **R)),
        (POSE_NOISE, lambda: UnscentedKalmanFilter(process_sigma=POSE_NOISE.sigma, **R)),
        (CORRELATED, lambda: with_covariance(UnscentedKalmanFilter, CORRELATED.Q)),
        (OnWheels.noise, lambda: OnWheels(**R)),
    ],
)
def test_with_the_noise_of_the_world_it_is_consistent(process_noise, make, rng):
    report = in_world_with(process_noise, rng, make)
    assert report.mean == pytest.approx(3, rel=0.15)
    assert report.inside > 0.7


# --- not seen


@pytest.mark.parametrize("kind", ALL)
def test_unseen_it_doubts_more_and_more_and_then_recovers(kind, rng):
    _, z, u = simulated_run(rng, 80, **TRUE_NOISES)
    z[40:60] = np.nan
    poses, covariances, velocities = filtered(kind(), z, u)
    variances = np.linalg.eigvalsh(covariances)
    assert (variances > 0).all()
    total = np.trace(covariances, axis1=1, axis2=2)
    assert (np.diff(total[39:60]) > 0).all()
    assert total[59] > 10 * total[39]
    assert total[70:] == pytest.approx(total[30:40].mean(), rel=0.3)
    assert np.isfinite(poses).all()
    assert velocities.shape == (80, 3)


@pytest.mark.parametrize("kind", ON_THE_MODEL)
def test_unseen_the_robot_is_driven_on_by_its_inputs(kind, rng):
    motion, states = RobotMotion(), [np.array([600, 600, 1, 0, 0, 0.0])]
    u = np.where(np.arange(80)[:, None] < 60, (0.1, 0.2), (1.0, 0.9))
    for k in range(1, 80):
        states.append(motion.move(states[-1], u[k]))
    truth = np.array(states)[:, :3]
    z = truth + rng.normal(0, (0.4, 0.4, 0.05), truth.shape)
    z[60:] = np.nan
    poses, *_ = filtered(kind(process_sigma=(0.02, 0.02, 0.001)), z, u)
    # at the speed of step 59 it would have come 19 px far
    assert np.hypot(*(truth[-1] - truth[59])[:2]) > 60
    assert np.hypot(*(poses - truth)[-1, :2]) < 5


def test_before_it_sees_the_robot_it_says_what_the_prior_is():
    for kind in ALL:
        estimate_state = kind(prior=PRIOR)
        for k in range(3):
            estimate = estimate_state(step_of(k, u=(1, 1)))
            np.testing.assert_allclose(estimate.pose, PRIOR.pose)
            np.testing.assert_allclose(np.diag(estimate.covariance), np.square(PRIOR.pose_sigma))
        estimate = kind()(step_of(0, (100, 1100, -3.0)))
        np.testing.assert_allclose(estimate.pose, (100, 1100, -3.0), atol=0.05)
        sigma = np.sqrt(np.diag(estimate.covariance))
        assert sigma == pytest.approx([0.3, 0.3, 0.05], rel=0.1)


# --- headings


@pytest.mark.long
@pytest.mark.parametrize("kind", ALL)
def test_the_seam_of_the_heading_is_nothing_to_it(kind, rng):
    z = rng.normal((600, 600, 0), (0.4, 0.4, 0.05), (120, 3))
    z[:, 2] += 0.1 * np.arange(len(z))
    z[50:60] = np.nan
    # turns by 0.1 rad a step: (0.03 + 0.02) 0.58 + 0.001 = (1 - 0.7) 0.1
    u = np.full((120, 2), (0.58, -0.58))
    runs = []
    for start in (0.0, np.pi, -2.0):
        turned = np.array([0, 0, start])
        model = {} if kind is ConstantVelocityKalmanFilter else {"model": LINEAR}
        estimate_state = kind(prior=Prior(pose=(600, 600, robsim.wrap_angle(start))), **model)
        poses, covariances, velocities = filtered(estimate_state, z + turned, u)
        assert (np.abs(poses[:, 2]) <= np.pi).all()
        runs.append((error_of(poses, turned), covariances, velocities))
    for run in runs[1:]:
        for values, expected in zip(run, runs[0], strict=True):
            np.testing.assert_allclose(values, expected, atol=1e-8)
    # at one step the filter without a model is out by 0.11 rad/s (one sigma)
    assert runs[0][2][80:, 2].mean() == pytest.approx(0.1 / DT, abs=0.05)


# --- as a callback


@pytest.mark.parametrize("kind", ALL)
def test_a_run_begins_anew(kind, rng):
    _, z, u = simulated_run(rng, 20, **TRUE_NOISES)
    estimate_state = kind()
    first = filtered(estimate_state, z, u)
    again = filtered(estimate_state, z, u)
    for values, expected in zip(again, first, strict=True):
        np.testing.assert_array_equal(values, expected)
    # a step that does not follow: it knows nothing of what was between
    for k in (3, 40):
        pose = estimate_state(step_of(k, (50, 60, 1))).pose
        np.testing.assert_allclose(pose, (50, 60, 1), atol=0.05)


def test_two_filters_do_not_touch_each_other(rng):
    _, z, u = simulated_run(rng, 20, **TRUE_NOISES)
    for kind in ALL:
        alone, one, other = kind(), kind(), kind()
        for k in range(20):
            other(step_of(k, z[19 - k], -u[k]))
            estimates = [each(step_of(k, z[k], u[k])) for each in (alone, one)]
            np.testing.assert_array_equal(estimates[0].pose, estimates[1].pose)


def test_the_seed_makes_the_particles(rng):
    z = rng.normal((600, 600, 0), (0.4, 0.4, 0.05), (5, 3))
    runs = [filtered(ParticleFilter(seed=seed), z)[0] for seed in (1, 1, 2)]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_resampling_takes_each_particle_as_often_as_its_weight_says():
    particles = ParticleFilter(n_particles=1000)
    particles.particles = np.arange(1000.0)[:, None] * np.ones(6)
    particles.weights = np.zeros(1000)
    particles.weights[[3, 10, 500]] = 0.5, 0.3004, 0.1996
    assert particles.effective_sample_size == pytest.approx(1 / (0.5**2 + 0.3004**2 + 0.1996**2))
    particles.resample()
    values, counts = np.unique(particles.particles[:, 0], return_counts=True)
    np.testing.assert_array_equal(values, [3, 10, 500])
    assert (np.abs(counts - (500, 300.4, 199.6)) < 1).all()
    assert particles.effective_sample_size == pytest.approx(1000)


def test_particles_that_are_all_elsewhere_find_the_robot_again():
    particles = ParticleFilter()
    for k in range(20):
        particles(step_of(k, (600, 600, 0)))
    for k in range(20, 60):
        estimate = particles(step_of(k, (200, 900, 2)))
    np.testing.assert_allclose(estimate.pose, (200, 900, 2), atol=1)


@pytest.mark.long
@pytest.mark.parametrize("kind", ON_THE_MODEL)
def test_without_process_noise_it_still_runs(kind, rng):
    errors = []
    # in the end the error of a run hardly changes: it is one number
    for _ in range(1 if kind is ParticleFilter else 6):
        states, z, u = simulated_run(rng, 250, (0, 0, 0), (0.4, 0.4, 0.05))
        poses, covariances, _ = filtered(kind(process_sigma=(0, 0, 0)), z, u)
        assert np.isfinite(covariances).all()
        errors.append(error_of(poses, states[:, :3])[150:])
    if kind is not ParticleFilter:  # nothing keeps the particles apart
        assert (rms(np.concatenate(errors)) < (0.1, 0.1, 0.002)).all()


# --- real tracking


@pytest.fixture(scope="module")
def tracked():
    """Runs with vision, dropouts and an extended filter: 36 headings shown, and any."""
    traces = {}
    for headings, options in ((36, {}), (None, CONTINUOUS)):
        sim = robsim.Simulation(
            robot="lab",
            measure=True,
            headings=headings,
            boundary="unlimited",
            control=robsim.DriveAround(),
            dropout=robsim.Dropout(0.1, steps=3),
            noise=None if headings else robsim.GaussianNoise(10),
            seed=4,
        )
        sim.estimate_state = ExtendedKalmanFilter(sim.model, **options)
        traces[headings] = sim.run(120)
    return traces


def inputs_before(trace):
    return np.vstack((np.zeros(2), trace.u[:-1]))


@pytest.mark.long
@pytest.mark.parametrize(
    ("headings", "kind", "options"),
    [
        # What the motors do in a step is far more than the noise of continuous frames: there a
        # filter that knows nothing of them is no better than the measurement.
        (36, ConstantVelocityKalmanFilter, {}),
        *[(36, kind, {}) for kind in ON_THE_MODEL],
        *[(None, kind, CONTINUOUS) for kind in ON_THE_MODEL],
    ],
)
def test_it_is_better_than_the_measurement(tracked, headings, kind, options):
    trace = tracked[headings]
    z, R = trace.pose_measured, trace.covariance_measured
    poses, *_ = filtered(kind(**options), z, inputs_before(trace), R=R)
    seen = trace.seen & (trace.k >= 10)
    assert 60 < np.sum(seen) < 110
    raw = rms(error_of(trace.pose_measured[seen], trace.pose_true[seen]))
    assert (rms(error_of(poses[seen], trace.pose_true[seen])) < 0.95 * raw).all()


@pytest.mark.parametrize("kind", ALL)
def test_it_uses_the_covariance_of_each_measurement(kind):
    z = np.array([[1.0, 2, 0.1], [1.5, 2.5, 0.2], [2.0, 2.2, 0.1]])
    sigmas = [(0.1, 0.2, 0.03), (0.4, 0.1, 0.01), (0.2, 0.2, 0.02)]
    R = np.array([np.diag(np.square(sigma)) for sigma in sigmas])
    estimate_state = kind(prior=PRIOR)
    given = filtered(estimate_state, z, R=R)
    np.testing.assert_array_equal(estimate_state.R, R[-1])
    # as if it had been set before each step
    estimate_state = kind(prior=PRIOR)
    for k in range(len(z)):
        estimate_state.R = R[k]
        estimate = estimate_state(step_of(k, z[k], (0, 0)))
        np.testing.assert_array_equal(estimate.pose, given[0][k])
        np.testing.assert_array_equal(estimate.covariance, given[1][k])
    # a sigma of its own, and an R that was set, hold for all
    own = filtered(kind(prior=PRIOR, measurement_sigma=sigmas[0]), z, R=R)
    fixed = filtered(kind(prior=PRIOR, measurement_sigma=sigmas[0]), z)
    for one, other in zip(own, fixed, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.array_equal(own[0], given[0])


@pytest.mark.long
@pytest.mark.parametrize("headings", [36, None])
def test_in_the_loop_it_gives_the_same(tracked, headings):
    trace = tracked[headings]
    options = {} if headings else CONTINUOUS
    poses, covariances, velocities = filtered(
        ExtendedKalmanFilter(**options),
        trace.pose_measured,
        inputs_before(trace),
        R=trace.covariance_measured,
    )
    np.testing.assert_array_equal(trace.pose_estimated, poses)
    np.testing.assert_array_equal(trace.covariance, covariances)
    np.testing.assert_array_equal(trace.state, velocities)


def test_it_gets_over_a_wall():
    motion, heading = [(800 + 4.0 * k, 600, 0.0) for k in range(40)], np.pi
    motion += [(956 - 4.0 * k, 600, heading) for k in range(40)]
    poses, *_ = filtered(ExtendedKalmanFilter(), np.array(motion), np.full((80, 2), 0.3))
    np.testing.assert_allclose(error_of(poses[-20:], np.array(motion[-20:])), 0, atol=1)


# --- wrong options


def test_options_beyond_their_limits_are_named():
    for kind in ON_THE_MODEL:
        with pytest.raises(ValueError, match=r"WheelNoise .*noise\.Q"):
            kind(process_sigma=robsim.WheelNoise(0.02).sigma)
    for kind, name, wrong in (
        (ExtendedKalmanFilter, "process_sigma", (0.1, 0.1, -1)),
        (UnscentedKalmanFilter, "kappa", -0.01),
        (ParticleFilter, "n_particles", 999),
        (ParticleFilter, "measurement_sigma", (1, 1)),
        (ConstantVelocityKalmanFilter, "measurement_sigma", (0, 1, 1)),
        (Prior, "pose", (1, 2)),
        (ParticleFilter, "seed", -1),
    ):
        with pytest.raises(ValueError, match=name):
            kind(**{name: wrong})
    assert ParticleFilter(n_particles=1000).effective_sample_size == pytest.approx(1000)


# --- a package that a course can leave out

WITHOUT = """
import importlib, pkgutil, sys
import robsim
for name in robsim.__all__:
    getattr(robsim, name)
assert "robsim.reference" not in sys.modules
sys.modules["robsim.reference"] = None  # as if the folder were not there
for module in pkgutil.walk_packages(robsim.__path__, "robsim."):
    unneeded = ("robsim.reference", "robsim.__main__", "robsim.simulation.templates")
    left_out = module.name.startswith(unneeded)
    is_of_windows = ".windows." in module.name and sys.platform != "win32"
    if not (left_out or is_of_windows):
        importlib.import_module(module.name)
"""


@pytest.mark.slow
def test_nothing_else_needs_it():
    run = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_two_simulations_in_turn_cannot_share_a_filter():
    shared = ConstantVelocityKalmanFilter()
    options = {"measure": lambda step: None, "estimate_state": shared}
    one, other = (robsim.Simulation(seed=seed, **options) for seed in (1, 2))
    one.step()
    other.step()
    one.step()
    with pytest.raises(RuntimeError, match="step 1 came twice"):
        other.step()


def test_a_collapsed_cloud_is_drawn_anew_all_the_same():
    collapsed = ParticleFilter(n_particles=1000)
    collapsed.particles[:] = collapsed.particles[0]
    collapsed.weights[:] = 0
    collapsed.weights[0] = 1
    collapsed.predict(np.zeros(2), 0.2)
    collapsed.P[:, 3:] = collapsed.P[3:, :] = 0  # no spread of velocities: P has no inverse
    z = collapsed.mean[:3] + np.array((5, 5, 0.1))
    collapsed.weights[:] = 0
    collapsed.weights[0] = 1
    collapsed.update(z)
    assert collapsed.effective_sample_size == pytest.approx(1000)
    spread = collapsed.particles.std(axis=0)
    assert (spread[:3] > 0.001).all()
    np.testing.assert_allclose(spread[3:], 0, atol=1e-9)


@pytest.mark.parametrize("kind", ALL)
def test_a_measurement_without_a_covariance_has_the_usual_one(kind):
    estimate_state = kind(prior=PRIOR)
    usual = estimate_state.R
    estimate_state(step_of(0, robsim.Measurement((1, 2, 0.1), covariance=1e-4 * np.eye(3))))
    assert not np.array_equal(estimate_state.R, usual)
    estimate_state(step_of(1, (1.0, 2.0, 0.1)))
    np.testing.assert_array_equal(estimate_state.R, usual)
    estimate_state(step_of(2, robsim.Measurement((1, 2, 0.1), covariance=1e-4 * np.eye(3))))
    estimate_state.reset()
    np.testing.assert_array_equal(estimate_state.R, usual)
    with pytest.raises(ValueError, match="R must"):
        estimate_state.R = np.eye(2)


def test_a_measurement_may_be_said_to_be_exact():
    exact = robsim.Measurement((1, 2, 0.1), covariance=np.zeros((3, 3)))
    for kind in ALL:
        estimate = kind(prior=PRIOR)(step_of(0, exact))
        np.testing.assert_allclose(estimate.pose, exact.pose, atol=1e-3)
