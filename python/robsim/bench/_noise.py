"""The benchmark of image noise against OpenCV and numpy."""

from __future__ import annotations

from typing import Any

import numpy as np

from robsim.bench._cases import Call
from robsim.bench._vision import NOISE_PERCENT
from robsim.imaging._images import Pixels
from robsim.imaging._noise import GaussianNoise, UniformNoise

SIGMA = 2.55 * NOISE_PERCENT  # grey levels


def gaussian_calls(cv2: Any, clean: Pixels) -> dict[str, Call]:
    """Return the calls that add Gaussian noise to an image: ours, opencv and numpy."""
    ours, noisy = GaussianNoise(NOISE_PERCENT), np.empty_like(clean)
    values, theirs = np.empty(clean.shape, np.int16), np.empty_like(clean)
    random = np.random.default_rng(1)

    def opencv() -> None:
        cv2.randn(values, 0, SIGMA)
        cv2.add(clean, values, theirs, dtype=cv2.CV_8U)

    def numpy() -> Pixels:
        values = random.standard_normal(clean.shape, dtype=np.float32)
        values *= np.float32(SIGMA)
        values += clean
        return np.clip(np.rint(values, out=values), 0, 255, out=values).astype(np.uint8)

    return {"ours": lambda: ours.add(clean, 1, 1, out=noisy), "opencv": opencv, "numpy": numpy}


def uniform_calls(cv2: Any, clean: Pixels) -> dict[str, Call]:
    """Return the calls that add uniform noise to an image: ours, opencv and numpy."""
    ours, noisy = UniformNoise(NOISE_PERCENT), np.empty_like(clean)
    values, theirs = np.empty(clean.shape, np.int16), np.empty_like(clean)
    random, half_width = np.random.default_rng(1), round(SIGMA)

    def opencv() -> None:
        cv2.randu(values, -half_width, half_width + 1)
        cv2.add(clean, values, theirs, dtype=cv2.CV_8U)

    def numpy() -> Pixels:
        values = random.integers(
            -half_width, half_width, clean.shape, dtype=np.int16, endpoint=True
        )
        values += clean
        return np.clip(values, 0, 255, out=values).astype(np.uint8)

    return {"ours": lambda: ours.add(clean, 1, 1, out=noisy), "opencv": opencv, "numpy": numpy}
