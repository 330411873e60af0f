"""Camera noise as a value, for `Simulation(noise=...)` or to add to any image."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import ClassVar

from robsim._core import VisualNoise
from robsim.base.checks import check_float, check_int
from robsim.base.text import quoted
from robsim.base.values import Level
from robsim.base.warn import warn_user
from robsim.vision.imaging.images import Pixels

#: Highest level of a noise (%).
HIGHEST = 100.0


@dataclass(frozen=True)
class _Noise:
    """Base of both noise types: level, kind, and the addition to an image."""

    percent: float

    _kind: ClassVar[str]
    _LEVEL: ClassVar[Level] = Level("%", high=HIGHEST, step=1.0, default=20.0)

    def __post_init__(self) -> None:
        check_float("percent", self.percent, "%", minimum=0, maximum=HIGHEST)
        if 0 < self.percent < 1:
            warn_user(
                f"a noise of {self.percent:g} is {self.percent:g} % of 0..255; "
                f"for {100 * self.percent:g} %, write {type(self).__name__}({100 * self.percent:g})"
            )

    @property
    def _level(self) -> float:
        return float(self.percent)

    @property
    def _native(self) -> VisualNoise:
        return native_noise(self._kind, float(self.percent))

    def add(self, image: Pixels, seed: int, index: int = 0, *, out: Pixels | None = None) -> Pixels:
        """Return an image with noise added.

        Parameters
        ----------
        image : array (H, W, 3) of uint8
            RGB.
        seed : int
            Seed of the random numbers, 0 <= seed < 2**64.
        index : int
            Number of the frame: each frame has independent noise.
        out : array (H, W, 3) of uint8, optional
            Array for the result; it may be `image` itself. Default: a new array.

        Returns
        -------
        array (H, W, 3) of uint8
            The noisy image: `out`, if it was given.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type, or an image the wrong shape. If `out` is read-only or
            overlaps the memory of `image` only in part.
        """
        seed = check_int("seed", seed, minimum=0, maximum=2**64 - 1)
        index = check_int("index", index, minimum=0, maximum=2**64 - 1)
        return self._native.add(image, seed, index, out=out)


@dataclass(frozen=True)
class GaussianNoise(_Noise):
    """Gaussian noise, independent for each pixel and channel, rounded and clipped to 0..255.

    The cumulative distribution is exact to 0.001, and the standard deviation to 0.5 %. Up to 6
    standard deviations, the frequency of rare values is exact, too.

    Parameters
    ----------
    percent : float
        Level p in % of the range 0..255: the standard deviation is 2.55 p grey levels.

    Raises
    ------
    TypeError, ValueError
        If `percent` is not a number within 0..100.

    Warns
    -----
    UserWarning
        If `percent` is below 1: a fraction may be meant.

    Examples
    --------
    >>> noise = robsim.GaussianNoise(40)
    >>> sim = robsim.Simulation(measure=True, headings=None, noise=noise, seed=1)
    >>> robsim.pose_errors(sim.run(100), of="measurement").rmse[:2].round(2)
    array([0.11, 0.13])
    """

    _kind: ClassVar[str] = "gaussian"


@dataclass(frozen=True)
class UniformNoise(_Noise):
    """Uniform noise, independent for each pixel and channel, rounded and clipped to 0..255.

    Parameters
    ----------
    percent : float
        Level p in % of the range 0..255: the noise lies within +-2.55 p grey levels.

    Raises
    ------
    TypeError, ValueError
        If `percent` is not a number within 0..100.

    Warns
    -----
    UserWarning
        If `percent` is below 1: a fraction may be meant.

    Examples
    --------
    >>> noise = robsim.UniformNoise(40)
    >>> sim = robsim.Simulation(measure=True, headings=None, noise=noise, seed=1)
    >>> robsim.pose_errors(sim.run(100), of="measurement").rmse[:2].round(2)
    array([0.08, 0.06])
    """

    _kind: ClassVar[str] = "uniform"


Noise = GaussianNoise | UniformNoise
#: The noises by their names.
NOISES: dict[str, type[Noise]] = {kind._kind: kind for kind in (UniformNoise, GaussianNoise)}


def as_native_noise(noise: Noise | None) -> VisualNoise:
    """Return the C++ core's noise for an option ``noise``; None = no noise."""
    if noise is None:
        return VisualNoise()
    if not isinstance(noise, _Noise):
        raise TypeError(
            f"noise must be a GaussianNoise, a UniformNoise or None, got {quoted(noise)}: write, "
            "for example, noise=robsim.GaussianNoise(40)"
        )
    return noise._native


def standard_deviation(noise: Noise | None) -> float:
    """Return the standard deviation of a noise before it is clipped (grey levels)."""
    if noise is None:
        return 0.0
    spread = 1.0 if isinstance(noise, GaussianNoise) else math.sqrt(3)
    return 2.55 * noise.percent / spread


@functools.lru_cache(maxsize=16)
def native_noise(kind: str, percent: float) -> VisualNoise:
    """Return the C++ core's noise; its tables are computed once per kind and level."""
    return VisualNoise(**{kind: percent})
