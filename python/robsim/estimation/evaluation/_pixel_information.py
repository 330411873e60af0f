"""What a pixel in noise tells of its mean: the information of a rounded, clipped value."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np

from robsim.base.checks import Floats
from robsim.vision.imaging.noise import GaussianNoise, Noise, UniformNoise

_ROUNDING = 1 / 12  # variance of the rounding error (grey levels^2)
_PER_LEVEL = 16  # means of the table in a grey level
_RARE = 1e-12  # probability of a value that tells nothing


def pixel_information(noise: Noise | None) -> Callable[[Floats], Floats]:
    """Return the function mean (N,) -> information of a pixel of that mean (N,).

    Parameters
    ----------
    noise : GaussianNoise, UniformNoise or None
        The camera's noise. None: rounding alone.

    Notes
    -----
    Gaussian noise: Fisher's information of the value k = round(mu + e), clipped to 0..255,

        J(mu) = sum_k P_k'(mu)^2 / P_k(mu)

    Others: that of the best estimate that is linear in the value, (d mean / d mu)^2 / variance.
    J is averaged over a grey level, as nobody knows how the mean lies between two, and is at most
    that of a value which is rounded without noise, 12.
    """
    if noise is None or noise.percent == 0:
        return lambda mean: np.full(len(mean), 1 / _ROUNDING)
    means, table = _table(noise)
    return lambda mean: np.interp(mean, means, table)


@functools.lru_cache(maxsize=32)
def _table(noise: GaussianNoise | UniformNoise) -> tuple[Floats, Floats]:
    """Return means (M,) and the information of each (M,)."""
    half = _PER_LEVEL // 2
    means = np.arange(-half, 255 * _PER_LEVEL + half + 1) / _PER_LEVEL
    # How far the limits between the values 0, 1, ... 255 lie above each mean.
    limits = np.arange(0.5, 255) - means[:, np.newaxis]
    scale = 2.55 * noise.percent
    table = _fisher(limits, scale) if isinstance(noise, GaussianNoise) else _linear(limits, scale)
    return means[half:-half], np.minimum(table, 1 / _ROUNDING)


def _fisher(limits: Floats, sigma: float) -> Floats:
    """Return Fisher's information for Gaussian noise, averaged over a grey level."""
    from scipy.special import ndtr

    z = limits / sigma
    ends = np.zeros((len(z), 1))
    # P_k = Phi(z_k+1) - Phi(z_k),  P_k' = (phi(z_k) - phi(z_k+1)) / sigma
    P = np.diff(np.hstack((ends, ndtr(z), ends + 1)))
    density = np.exp(-0.5 * np.square(z)) / (sigma * math.sqrt(2 * math.pi))
    change = np.diff(np.hstack((ends, density, ends)))
    terms = np.divide(np.square(change), P, out=np.zeros_like(P), where=P > _RARE)
    return _averaged(terms.sum(axis=1))


def _linear(limits: Floats, half_width: float) -> Floats:
    """Return the information of the best linear estimate for uniform noise, averaged likewise."""
    above = np.clip((half_width - limits) / (2 * half_width), 0, 1)
    # mean = sum P(value > k), mean of the square = sum (2 k + 1) P(value > k), k = 0..254
    mean = above.sum(axis=1)
    variance = above @ np.arange(1.0, 511, 2) - np.square(mean)
    slope = (np.abs(limits) < half_width).sum(axis=1) / (2 * half_width)
    bias = mean - (0.5 - limits[:, 0])
    spread = _averaged(variance + np.square(bias)) - np.square(_averaged(bias))
    information: Floats = np.square(_averaged(slope)) / spread
    return information


def _averaged(values: Floats) -> Floats:
    """Return the means over a grey level around each, which half a level at both ends lacks."""
    weights = np.full(_PER_LEVEL + 1, 1 / _PER_LEVEL)
    weights[[0, -1]] /= 2
    return np.convolve(values, weights, mode="valid")
