"""Disturbances of the world as values: process noise, and changed parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, islice
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import RobotModel, cos, random_normal, sin
from robsim.base.checks import Floats, as_float_array, check_float, check_int, check_kind
from robsim.base.text import quoted
from robsim.base.values import Level
from robsim.base.warn import warn_user

_Row = tuple[float, float, float]
_HEADING = 0.05  # rad of disturbance with each px, as in robsim.estimation.reference
_MAXIMUM_SIGMA = 1e6  # px or rad: its square is a number, too
# Columns of theta.
_A1, _A2, _B1, _B2, _D1 = range(5)


@dataclass(frozen=True)
class PoseNoise:
    """Gaussian process noise, added to the true pose in every step, independent of other steps.

    Parameters
    ----------
    covariance : array (3, 3)
        Covariance of x, y, heading in a step (px^2, px rad, rad^2), symmetric and positive
        semi-definite. The covariance is stored as nested tuples; `Q` returns it as an array.

    Raises
    ------
    TypeError, ValueError
        If `covariance` is not a covariance.

    Examples
    --------
    `Q` is the process noise covariance for a filter in the same world:

    >>> noise = robsim.PoseNoise.from_sigma(0.5, 0.5, 0.01)
    >>> noise.Q.diagonal().round(6)
    array([2.5e-01, 2.5e-01, 1.0e-04])
    """

    covariance: tuple[_Row, _Row, _Row] | ArrayLike

    _kind: ClassVar[str] = "pose"
    _LEVEL: ClassVar[Level] = Level("px", high=1.0, step=0.02, default=0.2)

    def __post_init__(self) -> None:
        matrix = as_float_array("covariance", self.covariance)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise ValueError(
                f"covariance must be an array of shape (3, 3), all finite, "
                f"got {quoted(self.covariance)}"
            )
        if not np.array_equal(matrix, matrix.T):
            raise ValueError(f"covariance must be symmetric, got {quoted(self.covariance)}")
        if not _is_semidefinite(matrix):
            raise ValueError(
                "covariance must be positive semi-definite (no negative variance in any "
                f"direction), got {quoted(self.covariance)}"
            )
        object.__setattr__(self, "covariance", tuple(map(tuple, matrix.tolist())))
        if (heading := self.sigma[2]) > np.pi:
            warn_user(
                f"a heading noise of {heading:.3g} rad is {np.degrees(heading):.0f} degrees in "
                f"each step: convert degrees with numpy.radians({heading:.3g})"
            )

    @classmethod
    def from_sigma(cls, x: float, y: float, heading: float) -> PoseNoise:
        """Return independent noises of these standard deviations.

        Parameters
        ----------
        x, y : float
            Standard deviations of the position in a step (px).
        heading : float
            Standard deviation of the heading in a step (rad).

        Raises
        ------
        TypeError, ValueError
            If a value is not a number within 0..1e6.
        """
        sigma = (
            check_float("x", x, "px", minimum=0, maximum=_MAXIMUM_SIGMA),
            check_float("y", y, "px", minimum=0, maximum=_MAXIMUM_SIGMA),
            check_float("heading", heading, "rad", minimum=0, maximum=_MAXIMUM_SIGMA),
        )
        return cls(np.diag(np.square(sigma)))

    @classmethod
    def _of_level(cls, level: float) -> PoseNoise:
        return cls.from_sigma(level, level, _HEADING * level)

    @property
    def _level(self) -> float:
        return float(self.sigma[:2].max())

    @property
    def Q(self) -> Floats:
        """Array (3, 3): the covariance in a step (px^2, px rad, rad^2); set a filter's Q to it."""
        return np.array(self.covariance)

    @property
    def factor(self) -> Floats:
        """Array (3, 3): the lower triangular L with L L' = Q."""
        Q, L = self.Q, np.zeros((3, 3))
        for j in range(3):
            # L(j, j)^2 = Q(j, j) - sum_m L(j, m)^2;  a column of zeros where nothing is left
            rest = Q[j:, j] - (L[j:, :j] * L[j, :j]).sum(axis=1)
            if rest[0] > 1e-12 * Q[j, j]:
                L[j:, j] = rest / np.sqrt(rest[0])
        return L

    @property
    def sigma(self) -> Floats:
        """Array (3,): standard deviations of x, y (px) and the heading (rad) in a step."""
        return np.sqrt(np.diag(self.Q))


def _is_semidefinite(matrix: Floats) -> bool:
    """Return whether no eigenvalue is negative beyond rounding, relative to the diagonal."""
    variances = np.diag(matrix)
    if (variances < 0).any():
        return False
    scale = np.sqrt(variances)
    unit = np.where(scale > 0, scale, 1.0)
    correlations = matrix / unit / unit[:, np.newaxis]
    return bool(np.linalg.eigvalsh(correlations).min() >= -1e-9)


@dataclass(frozen=True)
class WheelNoise:
    """Gaussian process noise on the voltages of the motors, independent for each motor.

    Parameters
    ----------
    sigma : float, or tuple of two floats
        Standard deviation in every step (V): for both motors, or for the left and the right one.

    Raises
    ------
    TypeError, ValueError
        If `sigma` is not one or two numbers of at least 0.

    Examples
    --------
    Noise of 0.02 V moves a robot that heads along x by 0.006 px in a step, and not across:

    >>> noise = robsim.WheelNoise(0.02)
    >>> np.sqrt(noise.Q(robsim.RobotModel(), heading=0.0).diagonal()).round(6)
    array([0.005893, 0.      , 0.000864])
    """

    sigma: float | Sequence[float]

    _kind: ClassVar[str] = "wheels"
    _LEVEL: ClassVar[Level] = Level("V", high=0.5, step=0.01, default=0.1)

    def __post_init__(self) -> None:
        if not isinstance(self.sigma, (tuple, list, np.ndarray)):
            check_float("sigma", self.sigma, "V", minimum=0)
            pair = (self.sigma, self.sigma)
        elif np.shape(self.sigma) == (2,):
            pair = tuple(self.sigma)
        else:
            raise ValueError(f"sigma must be one or two numbers (V), got {quoted(self.sigma)}")
        both = tuple(check_float("sigma", value, "V", minimum=0) for value in pair)
        object.__setattr__(self, "sigma", both)

    @property
    def _level(self) -> float:
        return float(np.max(self.sigma))

    def Q(self, model: RobotModel, heading: float) -> Floats:
        """Return the covariance of the pose that results from the noise in a step.

        Parameters
        ----------
        model : RobotModel
            The model of the robot.
        heading : float
            Heading of the robot before the step (rad).

        Returns
        -------
        array (3, 3)
            Covariance of x, y, heading (px^2, px rad, rad^2); set a filter's Q to it.

        Raises
        ------
        TypeError, ValueError
            If `model` is not a RobotModel, or `heading` is not a number.
        """
        b = _theta_of(model)[:, [_B1, _B2]]
        angle = check_float("heading", heading, "rad")
        # The noise w enters x as (b1X w1 + b2X w2) cos heading, y with sin, the heading as it is:
        # Q = G diag(sigma1^2, sigma2^2) G'
        G = b * np.array([[cos(angle)], [sin(angle)], [1.0]])
        scaled = G * np.asarray(self.sigma)
        # Row by row, so that Q is symmetric to the last bit.
        return np.array([[(row * other).sum() for other in scaled] for row in scaled])


@dataclass(frozen=True)
class ParameterMismatch:
    """Random differences between the world's parameters and the robot software's model.

    Parameters
    ----------
    sigma : float
        Relative standard deviation of the gains of the two motors and of the friction, 0..0.3.

    Raises
    ------
    TypeError, ValueError
        If `sigma` is not a number within 0..0.3.

    Notes
    -----
    Four numbers n are drawn from a standard normal distribution, and drawn again until they lie
    within +-3. The numbers apply to the gains alpha of the two motors, the friction Fv of the
    position and the friction Fw of the heading. Each value is multiplied by 1 + sigma n; mass,
    geometry and the torques at 0 V stay unchanged. In the model's parameters, with rho = F T/m (of
    the heading: Fw T/I) from a1 - 1 = 1/(1 + rho), per axis::

        rho' = (1 + sigma n) rho;
        a1' = a1 + delta,  a2' = a2 - delta,  delta = 1/(1 + rho') - 1/(1 + rho)
        bi' = (1 + sigma ni) bi (1 + rho)/(1 + rho'),  d1' = d1 (1 + rho)/(1 + rho')

    The axes X and Y share their draws.

    Examples
    --------
    >>> model = robsim.RobotModel()
    >>> world = robsim.ParameterMismatch(0.05).draw(model, np.random.default_rng(1))
    >>> (world.theta[2, :4] / model.theta[2, :4]).round(3)
    array([0.998, 0.996, 0.997, 1.054])
    """

    sigma: float
    _LEVEL: ClassVar[Level] = Level("", high=0.3, step=0.01, default=0.05)

    def __post_init__(self) -> None:
        sigma = check_float("sigma", self.sigma, minimum=0, maximum=self._LEVEL.high)
        object.__setattr__(self, "sigma", sigma)

    def draw(self, model: RobotModel, rng: np.random.Generator) -> RobotModel:
        """Return a world's model, which differs randomly from the given model.

        Parameters
        ----------
        model : RobotModel
            The model of the robot's software; its a1 must be above 1.
        rng : numpy.random.Generator
            Source of the seed of the numbers.

        Returns
        -------
        RobotModel
            The world's model.

        Raises
        ------
        TypeError
            If an argument has the wrong type.
        ValueError
            If a parameter a1 is not above 1, because friction then has no meaning.
        """
        theta = np.array(_theta_of(model))
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng must be a numpy.random.Generator, got {quoted(rng)}")
        if not (theta[:, _A1] > 1).all():
            raise ValueError(f"model must have all a1 between 1 and 2, got {theta[:, _A1]}")
        numbers = islice(_within_3(rng.bit_generator.random_raw()), 4)
        left, right, linear, angular = (1 + self.sigma * number for number in numbers)
        # a1 - 1 = 1/(1 + rho)
        rho = 1 / (theta[:, _A1] - 1) - 1
        changed = rho * (linear, linear, angular)
        delta = 1 / (1 + changed) - 1 / (1 + rho)
        theta[:, _A1] += delta
        theta[:, _A2] -= delta
        theta[:, _B1] *= left
        theta[:, _B2] *= right
        theta[:, [_B1, _B2, _D1]] *= ((1 + rho) / (1 + changed))[:, np.newaxis]
        return RobotModel.from_theta(theta, dt=model.dt)


def _within_3(seed: int) -> Iterator[float]:
    """Yield standard normal numbers within +-3 from the core, since numpy may change its own."""
    for i in count():
        if abs(number := random_normal(seed, i)) <= 3:
            yield number


def _theta_of(model: RobotModel) -> Floats:
    check_kind("model", model, RobotModel)
    return model.theta


@dataclass(frozen=True)
class Dropout:
    """Random occlusion: an object hides the robot from the camera.

    The run is divided into segments of `steps` steps. In each segment, the robot is hidden for the
    whole segment with this probability, independently of other segments.

    Parameters
    ----------
    probability : float
        Probability that the robot is hidden in a segment, 0..1.
    steps : int
        Length of a segment (steps), at least 1.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names the argument.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, dropout=robsim.Dropout(0.2, steps=5), seed=1)
    """

    probability: float
    steps: int = 1

    _LEVEL: ClassVar[Level] = Level("", high=1.0, step=0.01, default=0.0)

    def __post_init__(self) -> None:
        check_float("probability", self.probability, minimum=0, maximum=self._LEVEL.high)
        check_int("steps", self.steps, minimum=1, maximum=2**31 - 1)
