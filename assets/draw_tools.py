"""Small numpy helpers shared by the scripts that draw the default pictures."""

from __future__ import annotations

import numpy as np


def blur(field: np.ndarray, sigma: float | tuple[float, float]) -> np.ndarray:
    """Gaussian blur on a torus; `sigma` in samples, one number or (down, right)."""
    sigma_down, sigma_right = np.broadcast_to(np.asarray(sigma, float), 2)
    down = np.fft.fftfreq(field.shape[0])[:, None] * sigma_down
    right = np.fft.rfftfreq(field.shape[1])[None, :] * sigma_right
    transfer = np.exp(-2 * np.pi**2 * (down**2 + right**2))
    return np.fft.irfft2(np.fft.rfft2(field) * transfer, s=field.shape)


def noise(
    rng: np.random.Generator, shape: tuple[int, int], sigma: float | tuple[float, float]
) -> np.ndarray:
    """Smooth Gaussian noise that tiles: mean 0, standard deviation 1, grain about `sigma`."""
    field = blur(rng.standard_normal(shape), sigma)
    return (field - field.mean()) / field.std()


def ramp(value: np.ndarray, low: float, high: float) -> np.ndarray:
    """Smooth step: 0 where `value` is at `low`, 1 where it is at `high` (either order)."""
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def chroma(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """U - 128 and V - 128 (full-range BT.601) of an array whose last axis starts with R, G, B."""
    red, green, blue = (rgb[..., i].astype(float) for i in range(3))
    u = -0.169 * red - 0.331 * green + 0.5 * blue
    v = 0.5 * red - 0.419 * green - 0.081 * blue
    return u, v


def palette(value: np.ndarray, stops) -> np.ndarray:
    """Colours (..., 3) of values, linear between the stops (value, (r, g, b))."""
    at = [stop for stop, _ in stops]
    channels = np.array([colour for _, colour in stops], float).T
    return np.stack([np.interp(value, at, channel) for channel in channels], -1)
