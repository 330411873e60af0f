"""The benchmark of a whole noisy step (render, noise, detection) against OpenCV's functions."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from robsim._core import find_blobs
from robsim.bench._cases import Call
from robsim.bench._noise import SIGMA
from robsim.bench._render import render_calls
from robsim.bench._vision import NOISE_PERCENT, Scene, contours, opencv_finder, opencv_limits
from robsim.imaging._noise import GaussianNoise


def step_calls(cv2: Any, shown: Scene) -> dict[str, Call]:
    """Return the calls that draw the robot at its next pose, add noise and find its markers.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    shown : Scene
        The options of the marker detection; its frame has the size to be drawn.

    Returns
    -------
    dict of str to callable
        ``"ours"`` and ``"opencv"``.
    """
    size = shown.frame.image.shape[0]
    draw = render_calls(cv2, size)
    ours_noisy, theirs_noisy = (np.empty((size, size, 3), np.uint8) for _ in range(2))
    values = np.empty((size, size, 3), np.int16)
    noise, number = GaussianNoise(NOISE_PERCENT), itertools.count()
    limits = {color.name: opencv_limits(color) for color in shown.colors}
    find = opencv_finder(cv2, theirs_noisy, limits, shown.smoothing, contours)

    def ours() -> Any:
        noise.add(draw["ours"](), 1, next(number), out=ours_noisy)
        return find_blobs(
            ours_noisy, shown.colors, minimum_area=shown.minimum_area, smoothing=shown.smoothing
        )

    def opencv() -> Any:
        cv2.randn(values, 0, SIGMA)
        cv2.add(draw["opencv"](), values, theirs_noisy, dtype=cv2.CV_8U)
        return find()

    return {"ours": ours, "opencv": opencv}
