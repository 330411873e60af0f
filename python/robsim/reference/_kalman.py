"""The Kalman update with a measured pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robsim._base.checks import Floats
from robsim._core import wrap_angle
from robsim.reference._estimator import Prior, StateEstimator
from robsim.reference._noise import MEASUREMENT_NOISE, covariance

#: A measurement is the pose, the first half of the state: z = H x + noise.
H = np.eye(3, 6)


def innovation_of(z: Floats, poses: Floats) -> Floats:
    """Return what is new in a measured pose, (3,) or (N, 3): the short way round in heading."""
    # innovation = z - H x
    innovation = z - poses
    innovation[..., 2] = wrap_angle(innovation[..., 2])
    return innovation


def kalman_update(
    mean: Floats, P: Floats, z: Floats, R: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return mean, P, the innovation and its covariance S after a measured pose."""
    innovation = innovation_of(z, mean[:3])
    # S = H P H' + R
    S = H @ P @ H.T + R
    # K = P H' S^-1
    K = np.linalg.solve(S, H @ P).T
    # x = x + K innovation
    mean = mean + K @ innovation
    mean[2] = wrap_angle(mean[2])
    # P = (I - K H) P (I - K H)' + K R K'  (Joseph's form: it stays symmetric and positive)
    rest = np.eye(6) - K @ H
    return mean, rest @ P @ rest.T + K @ R @ K.T, innovation, S


class KalmanFilter(StateEstimator):
    """A filter whose belief is a normal distribution; its kinds differ in how they predict.

    Attributes
    ----------
    mean : array (6,)
        The estimated state: x, y, heading and their velocities.
    P : array (6, 6)
        Its covariance.
    innovation, S : array (3,), array (3, 3), or None
        Of the newest step, the measured pose minus the predicted one, and its covariance. None if
        the robot was not seen.
    """

    innovation: Floats | None
    S: Floats | None

    def __init__(
        self, *, measurement_noise: Sequence[float] = MEASUREMENT_NOISE, prior: Prior | None = None
    ) -> None:
        self.R = covariance("measurement_noise", measurement_noise, exclusive_minimum=0)
        super().__init__(prior)

    def reset(self) -> None:
        """Forget the run: what is known is the prior."""
        super().reset()
        self.innovation = self.S = None

    def _predicted(self, mean: Floats, P: Floats) -> None:
        """Keep what was predicted for this step."""
        mean[2] = wrap_angle(mean[2])
        self.mean, self.P = mean, P
        self.innovation = self.S = None

    def update(self, z: Floats) -> None:
        """Take in a measured pose, (3,)."""
        self.mean, self.P, self.innovation, self.S = kalman_update(self.mean, self.P, z, self.R)
