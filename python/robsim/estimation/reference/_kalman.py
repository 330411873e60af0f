"""The Kalman update with a measured pose, which all reference filters use."""

from __future__ import annotations

import numpy as np

from robsim._core import wrap_angle
from robsim.base.checks import Floats, as_float_array
from robsim.estimation.reference.estimator import StateEstimator

#: The measurement is the pose, the first half of the state: z = H x + noise.
H = np.eye(3, 6)


def innovation_of(z: Floats, poses: Floats) -> Floats:
    """Return the innovations of a measured pose z, (3,), at poses (3,) or (N, 3); wrapped."""
    z = as_float_array("z", z)
    if z.shape != (3,):
        raise ValueError(f"z must be a pose (x, y, heading), got the shape {z.shape}")
    # innovation = z - H x
    innovation = z - poses
    innovation[..., 2] = wrap_angle(innovation[..., 2])
    return innovation


def kalman_update(
    mean: Floats, P: Floats, z: Floats, R: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the updated mean and P, the innovation and its covariance S."""
    innovation = innovation_of(z, mean[:3])
    # S = H P H' + R
    S = H @ P @ H.T + R
    # K = P H' S^-1
    K = np.linalg.solve(S, H @ P).T
    # x = x + K innovation
    mean = mean + K @ innovation
    mean[2] = wrap_angle(mean[2])
    # P = (I - K H) P (I - K H)' + K R K'  (Joseph form: stays symmetric positive definite)
    I_KH = np.eye(6) - K @ H
    return mean, I_KH @ P @ I_KH.T + K @ R @ K.T, innovation, S


class KalmanFilter(StateEstimator):
    """A filter whose state is normally distributed; the subclasses differ in the prediction.

    Attributes
    ----------
    mean : array (6,)
        The estimated state: x, y, heading and their velocities.
    P : array (6, 6)
        Its covariance.
    innovation, S : array (3,), array (3, 3), or None
        The measured minus the predicted pose of the last step, and its covariance. None if the
        robot was not seen.
    """

    innovation: Floats | None
    S: Floats | None

    def reset(self) -> None:
        """Return to the prior."""
        super().reset()
        self.innovation = self.S = None

    def _set_prediction(self, mean: Floats, P: Floats) -> None:
        """Keep the predicted mean and covariance."""
        mean[2] = wrap_angle(mean[2])
        self.mean, self.P = mean, P
        self.innovation = self.S = None

    def update(self, z: Floats) -> None:
        """Update the state with a measured pose z, (3,), whose covariance is `R`."""
        self.mean, self.P, self.innovation, self.S = kalman_update(self.mean, self.P, z, self.R)
