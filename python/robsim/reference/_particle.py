"""The particle filter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._base.checks import Floats, check_int
from robsim._base.seeds import Seed, seed_sequence
from robsim._core import RobotModel, wrap_angle
from robsim.reference._estimator import Prior, StateEstimator
from robsim.reference._kalman import innovation_of, kalman_update
from robsim.reference._motion import RobotMotion
from robsim.reference._noise import MEASUREMENT_NOISE, PROCESS_NOISE, check_vector3

#: With fewer effective particles after a measurement, the cloud is drawn anew.
FEWEST = 200


class ParticleFilter(StateEstimator):
    """A cloud of states that move as the robot model does, each weighed by the measurements.

    Where hardly a particle is near the measurement, at the start and at a wall, the cloud is taken
    for a normal distribution and drawn anew from what the measurement makes of that.

    Parameters
    ----------
    model, process_noise, measurement_noise, prior
        As of `ExtendedKalmanFilter`. The process noise is what keeps the particles apart.
    count : int
        Number of particles, at least 1000.
    seed : int, SeedSequence, Generator or None
        What its random numbers come from; the same in each run.

    Attributes
    ----------
    particles : array (count, 6)
        The states.
    weights : array (count,)
        Their weights; the sum is 1.

    Raises
    ------
    TypeError, ValueError
        As of `ExtendedKalmanFilter`.

    Notes
    -----
    Source: Gordon, Salmond and Smith, Novel approach to nonlinear/non-Gaussian Bayesian state
    estimation, IEE Proc. F 140(2), 1993 (the bootstrap filter); systematic resampling: Kitagawa,
    Monte Carlo Filter and Smoother, J. Comput. Graph. Stat. 5(1), 1996; drawing anew: Kotecha and
    Djuric, Gaussian Particle Filtering, IEEE Trans. Signal Process. 51(10), 2003.

    Examples
    --------
    >>> import robsim.reference
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> sim.estimate_state = robsim.reference.ParticleFilter(sim.model)
    >>> trace = sim.run(100)
    """

    particles: Floats
    weights: Floats

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        process_noise: Sequence[float] = PROCESS_NOISE,
        measurement_noise: Sequence[float] = MEASUREMENT_NOISE,
        count: int = 2000,
        seed: Seed = 0,
        prior: Prior | None = None,
    ) -> None:
        self.motion = RobotMotion(model)
        self.process_noise = check_vector3("process_noise", process_noise, minimum=0)
        self.measurement_noise = check_vector3(
            "measurement_noise", measurement_noise, exclusive_minimum=0
        )
        self.count = check_int("count", count, minimum=1000, maximum=10**7)
        self._seed = seed_sequence(seed)
        super().__init__(prior)

    def reset(self) -> None:
        """Forget the run: what is known is the prior."""
        super().reset()
        self._rng = np.random.default_rng(self._seed)
        self._draw(self.mean, self.P)

    @property
    def effective_count(self) -> float:
        """As many particles of equal weight would say as much."""
        # N_eff = 1 / sum W_i^2
        return float(1 / np.sum(self.weights**2))

    def predict(self, u: Floats, dt: float) -> None:
        """Go on by dt (s), a step of the model or several, with the input u (V)."""
        if self.effective_count < self.count / 2:
            self.resample()
        for _ in range(self.motion.steps_in(dt)):
            # x_i = f(x_i, u) + G w_i
            w = self.process_noise * self._rng.standard_normal((self.count, 3))
            self.particles = self.motion.move(self.particles, u) + w @ self.motion.G.T
        self._summarise()

    def update(self, z: Floats) -> None:
        """Take in a measured pose, (3,)."""
        # W_i = W_i p(z | x_i), normally distributed
        distance = innovation_of(z, self.particles[:, :3]) / self.measurement_noise
        log_likelihood = -np.sum(distance**2, axis=1) / 2
        # less the largest: the exponential of all of them may be too small for a float
        weights = self.weights * np.exp(log_likelihood - log_likelihood.max())
        self.weights = weights / weights.sum()
        if self.effective_count < FEWEST:
            self._start_over(z)
        self._summarise()

    def _start_over(self, z: Floats) -> None:
        """Draw the cloud anew from what z makes of its mean and covariance."""
        R = np.diag(self.measurement_noise**2)
        mean, P, *_ = kalman_update(self.mean, self.P, z, R)
        self._draw(mean, P)

    def _draw(self, mean: Floats, P: Floats) -> None:
        """Draw the particles from a normal distribution."""
        # x_i = mean + L n_i with L L' = P and n_i of unit covariance
        self.particles = mean + self._rng.standard_normal((self.count, 6)) @ _root(P).T
        self.weights = np.full(self.count, 1 / self.count)

    def resample(self) -> None:
        """Draw each particle as often as its weight says: systematic resampling."""
        # the points (i + random) / N, i = 0..N-1, among the sums of the weights
        points = (np.arange(self.count) + self._rng.random()) / self.count
        chosen = np.searchsorted(np.cumsum(self.weights), points, side="right")
        self.particles = self.particles[np.minimum(chosen, self.count - 1)]
        self.weights = np.full(self.count, 1 / self.count)

    def _summarise(self) -> None:
        """Take mean and covariance of the particles."""
        # mean = sum W_i x_i, that of the heading on the circle
        self.mean = self.weights @ self.particles
        heading = self.particles[:, 2]
        self.mean[2] = np.arctan2(self.weights @ np.sin(heading), self.weights @ np.cos(heading))
        # P = sum W_i (x_i - x)(x_i - x)'
        deviation = self.particles - self.mean
        deviation[:, 2] = wrap_angle(deviation[:, 2])
        self.P = (self.weights * deviation.T) @ deviation


def _root(P: Floats) -> Floats:
    """Return L with L L' = P, the same on every processor.

    Eigenvectors alone are not: for equal eigenvalues any basis will do, and kernels of the linear
    algebra differ in the one they give.
    """
    try:
        return np.asarray(np.linalg.cholesky(P), dtype=np.float64)
    except np.linalg.LinAlgError:  # a collapsed cloud: P is singular
        # P^(1/2) = V sqrt(D) V' is unique, whatever V is
        eigenvalues, V = np.linalg.eigh(P)
        return np.asarray((V * np.sqrt(np.maximum(eigenvalues, 0))) @ V.T, dtype=np.float64)
