"""The lens of a simulated camera."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Intrinsics
from robsim.base.checks import Floats, check_float, check_size


@dataclass(frozen=True)
class Lens:
    """A lens with radial distortion about the centre of the frame.

    Let r be the distance of a point from the centre in an ideal picture, as a fraction of half the
    frame's diagonal. This lens moves the point to the distance r (1 + k1 r^2 + k2 r^4): a k1 of
    -0.04 moves the corners inwards by 4 %.

    Parameters
    ----------
    k1, k2 : float
        The coefficients; ``Lens()`` does not distort.

    Raises
    ------
    TypeError, ValueError
        If a coefficient is not a finite number.

    Notes
    -----
    Source: D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971;
    the radial terms.

    Examples
    --------
    >>> lens = robsim.lab.Lens(k1=-0.05)
    >>> with robsim.lab.SimulatedLab(lens=lens) as lab, robsim.Camera(lab) as camera:
    ...     print(camera.read().image.shape)
    (1200, 1200, 3)
    """

    k1: float = 0.0
    k2: float = 0.0

    def __post_init__(self) -> None:
        check_float("k1", self.k1)
        check_float("k2", self.k2)

    def distorted(self, pixels: ArrayLike, size: tuple[int, int]) -> Floats:
        """Return the frame pixels of the points that an ideal lens would show at `pixels`.

        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Ideal pixels (u, v).
        size : tuple of int
            Width and height of the frames (px).

        Returns
        -------
        array (2,) or (N, 2)
            Pixels (u, v) of the frames.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape, or the lens would fold such frames over.
        """
        return self._before(size).distorted(pixels)

    def ideal(self, pixels: ArrayLike, size: tuple[int, int]) -> Floats:
        """Return the pixels at which an ideal lens would show the points at these frame pixels.

        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Pixels (u, v) of the frames.
        size : tuple of int
            Width and height of the frames (px).

        Returns
        -------
        array (2,) or (N, 2)
            Ideal pixels (u, v).

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong type or shape, or the lens would fold such frames over.
        """
        return self._before(size).ideal(pixels)

    def _before(self, size: tuple[int, int]) -> Intrinsics:
        """Return the intrinsics of a camera with frames of a size, r in halves of the diagonal."""
        width, height = check_size("size", size)
        half = math.sqrt(width * width + height * height) / 2
        middle = ((width - 1) / 2, (height - 1) / 2)
        matrix = ((half, 0, middle[0]), (0, half, middle[1]), (0, 0, 1))
        intrinsics = Intrinsics(matrix, (self.k1, self.k2, 0, 0, 0))
        if np.isnan(intrinsics.ideal((-0.5, -0.5))).any():
            raise ValueError(
                "k1 and k2 must keep the order of the pixels from the centre to the corners; with "
                "these values, the lens folds the picture over"
            )
        return intrinsics
