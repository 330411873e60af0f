import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from robsim.estimation.reference import (
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


def model_axis(axis, z, u):
    """The oracle for an axis of LINEAR; its states are the last two places."""
    a1, a2, b1, b2, d1 = LINEAR.theta[axis]
    place = PRIOR.pose_sigma[axis] ** 2
    before = place + (DT * PRIOR.velocity_sigma[axis]) ** 2
    push = np.zeros((len(z), 2))
    push[:, 0] = b1 * u[:, 0] + b2 * u[:, 1] + (d1 if axis == 2 else 0)
    return plain_kalman_filter(
        z[:, axis],
        F=np.array([[a1, a2], [1, 0]]),
        Q=np.diag([NOISES["process_sigma"][axis] ** 2, 0]),
        P=np.array([[place, place], [place, before]]),
        x=np.full(2, float(PRIOR.pose[axis])),
        R=NOISES["measurement_sigma"][axis] ** 2,
        push=push,
    )


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter])
def test_on_a_linear_model_it_is_the_plain_kalman_filter(kind, rng):
    z, u = linear_problem(rng)
    poses, covariances, _ = filtered(kind(LINEAR, prior=PRIOR, **NOISES), z, u)
    for axis in range(3):
        mean, variance = model_axis(axis, z, u)
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
    by_axis = [model_axis(axis, z, u) for axis in range(3)]
    mean, variance = np.moveaxis(np.array(by_axis), 0, -1)
    # thousands of effective particles: mean and variance are right within a few hundredths
    assert rms(((poses - mean) / np.sqrt(variance)).ravel()) < 0.07
    ratio = np.diagonal(covariances, axis1=1, axis2=2) / variance
    assert rms(ratio.ravel() - 1) < 0.07


# --- the robot model in state space


def test_it_moves_as_the_model_predicts(rng):
    motion, model = RobotMotion(), robsim.RobotModel()
    last, before = rng.uniform((-500, -500, -3), (500, 500, 3), (2, 20, 3))
    u = rng.uniform(-1, 1, 2)
    states = np.hstack((last, error_of(last, before) / DT))
    moved = motion.move(states, u)
    for state, now, earlier in zip(moved, last, before, strict=True):
        pose = model.predict(now, earlier, u)
        np.testing.assert_allclose(error_of(state[:3], pose), 0, atol=1e-9)
        np.testing.assert_allclose(state[3:], (state[:3] - now) / DT, atol=1e-9)


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


TRUE_NOISES = {"process_sigma": (0.1, 0.1, 0.005), "measurement_sigma": (0.4, 0.4, 0.05)}


# --- the process noise of a simulation


class OnWheels(ExtendedKalmanFilter):
    """The extended filter with the covariance of noise on the wheels, at the estimated heading."""

    noise = robsim.WheelNoise((0.2, 0.3))

    def predict(self, u, dt):
        self.Q = self.noise.Q(self.motion.model, self.mean[2])
        super().predict(u, dt)


class OnPoses(UnscentedKalmanFilter):
    noise = robsim.PoseNoise([[0.09, 0.05, 0], [0.05, 0.04, 0], [0, 0, 1e-4]])

    def predict(self, u, dt):
        self.Q = self.noise.Q
        super().predict(u, dt)


def inputs_before(trace):
    return np.vstack((np.zeros(2), trace.u[:-1]))


@pytest.mark.long
@pytest.mark.parametrize("kind", [OnWheels, OnPoses])
def test_with_the_noise_of_the_world_it_is_consistent(kind, rng):
    errors, covariances = [], []
    for seed in range(20):
        options = {"boundary": "unlimited", "control": robsim.DriveAround(), "seed": seed}
        trace = robsim.Simulation(process_noise=kind.noise, **options).run(100)
        sigma = (0.4, 0.4, 0.02)
        z = trace.pose_true + rng.normal(0, sigma, (100, 3))
        poses, P, _ = filtered(kind(measurement_sigma=sigma), z, inputs_before(trace))
        errors.append(error_of(poses, trace.pose_true)[10:])  # after the prior is forgotten
        covariances.append(P[10:])
    report = robsim.estimation.nees_consistency(np.array(errors), np.array(covariances))
    assert report.mean == pytest.approx(3, rel=0.15)
    assert report.inside > 0.7


# --- not seen


@pytest.mark.parametrize("kind", ALL)
def test_unseen_it_doubts_more_and_more_and_then_recovers(kind, rng):
    _, z, u = simulated_run(rng, 80, **TRUE_NOISES)
    z[40:60] = np.nan
    _, covariances, _ = filtered(kind(), z, u)
    total = np.trace(covariances, axis1=1, axis2=2)
    assert (np.diff(total[39:60]) > 0).all()
    assert total[59] > 10 * total[39]
    assert total[70:] == pytest.approx(total[30:40].mean(), rel=0.3)


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


# --- real tracking


@pytest.fixture(scope="module")
def tracked():
    """A run with vision, dropouts and an extended filter."""
    sim = robsim.Simulation(
        robot="lab",
        measure=True,
        boundary="unlimited",
        control=robsim.DriveAround(),
        dropout=robsim.Dropout(0.1, steps=3),
        seed=4,
    )
    sim.estimate_state = ExtendedKalmanFilter(sim.model)
    return sim.run(120)


@pytest.mark.long
@pytest.mark.parametrize("kind", ALL)
def test_it_is_better_than_the_measurement(tracked, kind):
    R = tracked.covariance_measured
    given = filtered(kind(), tracked.pose_measured, inputs_before(tracked), R=R)
    seen = tracked.seen & (tracked.k >= 10)
    assert 60 < np.sum(seen) < 110
    raw = rms(error_of(tracked.pose_measured[seen], tracked.pose_true[seen]))
    assert (rms(error_of(given[0][seen], tracked.pose_true[seen])) < 0.95 * raw).all()
    if kind is ExtendedKalmanFilter:  # the one of the run
        names = ("pose_estimated", "covariance", "state")
        for name, values in zip(names, given, strict=True):
            np.testing.assert_array_equal(getattr(tracked, name), values)


@pytest.mark.parametrize("kind", ALL)
def test_it_uses_the_covariance_of_each_measurement_else_the_usual_one(kind):
    z = np.array([[1.0, 2, 0.1], [1.5, 2.5, 0.2], [2.0, 2.2, 0.1]])
    sigmas = [(0.1, 0.2, 0.03), (0.4, 0.1, 0.01), (0.2, 0.2, 0.02)]
    R = np.array([np.diag(np.square(sigma)) for sigma in sigmas])
    estimate_state = kind(prior=PRIOR)
    usual = estimate_state.R
    given = filtered(estimate_state, z, R=R)
    np.testing.assert_array_equal(estimate_state.R, R[-1])
    estimate_state(step_of(3, z[0]))
    np.testing.assert_array_equal(estimate_state.R, usual)
    # as if it had been set before each step
    for k in range(len(z)):
        estimate_state.R = R[k]
        estimate = estimate_state(step_of(k, z[k], (0, 0)))
        np.testing.assert_array_equal(estimate.pose, given[0][k])
        np.testing.assert_array_equal(estimate.covariance, given[1][k])
    # a sigma of its own holds for all
    own = filtered(kind(prior=PRIOR, measurement_sigma=sigmas[0]), z, R=R)
    fixed = filtered(kind(prior=PRIOR, measurement_sigma=sigmas[0]), z)
    np.testing.assert_array_equal(own[1], fixed[1])
    assert not np.array_equal(own[0], given[0])
    with pytest.raises(ValueError, match="R must"):
        estimate_state.R = np.eye(2)


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
assert "robsim.estimation.reference" not in sys.modules
sys.modules["robsim.estimation.reference"] = None  # as if the folder were not there
for module in pkgutil.walk_packages(robsim.__path__, "robsim."):
    unneeded = ("robsim.estimation.reference", "robsim.__main__", "robsim.simulation.templates")
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
