"""The particle filter on the robot model."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Self

import numpy as np

from robsim._core import RobotModel, wrap_angle
from robsim.base.checks import Floats, check_int
from robsim.base.seeds import Seed, seed_sequence
from robsim.estimation.reference.estimator import PROCESS_SIGMA, Prior, check_process_sigma, root
from robsim.estimation.reference.kalman import ModelFilter, innovation_of, kalman_update

#: With a smaller effective sample size after a measurement, the particles are drawn again.
MINIMUM_SAMPLE_SIZE = 600


class ParticleFilter(ModelFilter):
    """A set of states, moved by the robot model and weighted by the measurements.

    If few particles are near the measurement, as at the start and at a wall, a sample from a normal
    distribution replaces them: the Kalman update of their mean and covariance.

    Parameters
    ----------
    model, process_sigma, measurement_sigma, motor_delay, prior
        As for `ExtendedKalmanFilter`: by default R is the covariance of each measurement. The
        process noise keeps the particles apart.
    n_particles : int
        Number of particles, at least 1000.
    seed : int, SeedSequence, Generator or None
        Seed of the random numbers; they are the same in each run.

    Attributes
    ----------
    particles : array (n_particles, 6)
        The states of the particles.
    weights : array (n_particles,)
        Their weights; the sum is 1.

    Raises
    ------
    TypeError, ValueError
        As for `ExtendedKalmanFilter`.

    Notes
    -----
    Source: Gordon, Salmond and Smith, Novel approach to nonlinear/non-Gaussian Bayesian state
    estimation, IEE Proc. F 140(2), 1993 (the bootstrap filter); systematic resampling: Kitagawa,
    Monte Carlo Filter and Smoother, J. Comput. Graph. Stat. 5(1), 1996; drawing again: Kotecha and
    Djuric, Gaussian Particle Filtering, IEEE Trans. Signal Process. 51(10), 2003.

    Examples
    --------
    Root mean square error of the heading (rad), measured and estimated:

    >>> sim = robsim.Simulation(measure=True, control=robsim.DriveAround(), seed=1)
    >>> sim.estimate_state = robsim.estimation.reference.ParticleFilter(sim.model)
    >>> trace = sim.run(100)
    >>> kinds = "measurement", "estimate"
    >>> [robsim.pose_errors(trace, of=one).rmse[2].round(2).item() for one in kinds]
    [0.05, 0.02]
    """

    particles: Floats
    weights: Floats

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_sigma: Sequence[float] = PROCESS_SIGMA,
        measurement_sigma: Sequence[float] | None = None,
        n_particles: int = 2000,
        seed: Seed = 0,
        motor_delay: float = 0.0,
        prior: Prior | None = None,
    ) -> None:
        self.process_sigma = check_process_sigma(process_sigma)
        self.n_particles = check_int("n_particles", n_particles, minimum=1000, maximum=10**7)
        self._seed = seed_sequence(seed)
        super().__init__(
            model, motor_delay=motor_delay, measurement_sigma=measurement_sigma, prior=prior
        )

    def reset(self) -> None:
        """Return to the prior."""
        super().reset()
        self._rng = np.random.default_rng(self._seed)
        self._draw(self.mean, self.P)

    def _copy(self) -> Self:
        other = super()._copy()
        # Prediction must not change later random numbers.
        other._rng = copy.deepcopy(self._rng)
        return other

    @property
    def effective_sample_size(self) -> float:
        """The number of particles of equal weight that would carry the same information."""
        # N_eff = 1 / sum W_i^2
        return float(1 / np.sum(self.weights**2))

    def predict(self, u: Floats, dt: float) -> None:
        """Predict the state dt (s) ahead, as `ExtendedKalmanFilter.predict`."""
        if self.effective_sample_size < self.n_particles / 2:
            self.resample()
        for acting in self._inputs(u, dt):
            # x_i = f(x_i, u) + G w_i
            w = self.process_sigma * self._rng.standard_normal((self.n_particles, 3))
            self.particles = self.motion.move(self.particles, acting) + w @ self.motion.G.T
        self._summarise()

    def update(self, z: Floats) -> None:
        """Update the weights with a measured pose z, (3,), whose covariance is `R`."""
        # W_i = W_i p(z | x_i), normally distributed: p = exp(-|L^-1 (z - x_i)|^2 / 2), L L' = R
        # An exact measurement still gets a standard deviation of 1e-6.
        L = root(self.R + 1e-12 * np.eye(3))
        distance = np.linalg.solve(L, innovation_of(z, self.particles[:, :3]).T)
        log_likelihood = -np.sum(distance**2, axis=0) / 2
        # minus the maximum: otherwise all exponentials may underflow
        weights = self.weights * np.exp(log_likelihood - log_likelihood.max())
        self.weights = weights / weights.sum()
        if self.effective_sample_size < MINIMUM_SAMPLE_SIZE:
            self._redraw(z)
        self._summarise()

    def _redraw(self, z: Floats) -> None:
        """Draw new particles from the Kalman update of their mean and covariance with z."""
        mean, P, *_ = kalman_update(self.mean, self.P, z, self.R)
        self._draw(mean, P)

    def _draw(self, mean: Floats, P: Floats) -> None:
        """Draw the particles from a normal distribution."""
        # x_i = mean + L n_i with L L' = P and n_i of unit covariance
        self.particles = mean + self._rng.standard_normal((self.n_particles, 6)) @ root(P).T
        self.weights = np.full(self.n_particles, 1 / self.n_particles)

    def resample(self) -> None:
        """Draw particles in proportion to their weights: systematic resampling."""
        # the points (i + random) / N, i = 0..N-1, in the cumulative sum of the weights
        points = (np.arange(self.n_particles) + self._rng.random()) / self.n_particles
        chosen = np.searchsorted(np.cumsum(self.weights), points, side="right")
        self.particles = self.particles[np.minimum(chosen, self.n_particles - 1)]
        self.weights = np.full(self.n_particles, 1 / self.n_particles)

    def _summarise(self) -> None:
        """Set the mean and the covariance from the particles."""
        # mean = sum W_i x_i; for the heading the circular mean
        self.mean = self.weights @ self.particles
        heading = self.particles[:, 2]
        self.mean[2] = np.arctan2(self.weights @ np.sin(heading), self.weights @ np.cos(heading))
        # P = sum W_i (x_i - x)(x_i - x)'
        deviation = self.particles - self.mean
        deviation[:, 2] = wrap_angle(deviation[:, 2])
        self.P = (self.weights * deviation.T) @ deviation
