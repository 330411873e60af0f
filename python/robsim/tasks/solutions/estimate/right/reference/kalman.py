"""An extended Kalman filter for the pose of the robot."""

import numpy as np
from task import AREA, THETA

import robsim

# The model: pose(k) = a1 pose(k-1) + a2 pose(k-2) + (b1 u1 + b2 u2 + d1) (cos h, sin h, 1),
# with the heading h of step k-1.
a1, a2, b1, b2, d1 = np.array(THETA).T

# Before the robot is seen: somewhere in the work area, with any heading.
CENTRE = np.array([AREA[0] / 2, AREA[1] / 2, 0.0])
ANYWHERE = np.diag([AREA[0] ** 2 / 12, AREA[1] ** 2 / 12, np.pi**2 / 3])

# How far the robot may have moved in the step before it is first seen: px, px, rad.
FIRST_STEP = np.diag([5.0**2, 5.0**2, 0.1**2])


def wrap(angle):
    """Return an angle between -pi and pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


class KalmanFilter:
    """The state is the last pose and the one before, since the model needs both.

    Headings in it are not wrapped: between two steps they must not jump.
    """

    def __init__(self, measurement_sigma, process_sigma):
        self.R = np.diag(np.square(measurement_sigma))
        self.Q = np.diag(np.square(process_sigma))
        self.x = self.P = None  # not seen yet

    def __call__(self, step):
        """Return the estimate of a step."""
        z = None if step.measurement is None else step.measurement.pose
        if self.x is not None:
            self.predict(step.last_u)
            if z is not None:
                self.update(z)
        elif z is not None:
            self.start(z)
        else:
            return robsim.Estimate(CENTRE, ANYWHERE)
        return robsim.Estimate(self.x[:3], self.P[:3, :3])

    def start(self, z):
        """Begin with the first measurement."""
        self.x = np.concatenate((z, z))
        # pose(k) = z + error,  pose(k-1) = pose(k) - what it moved
        self.P = np.block([[self.R, self.R], [self.R, self.R + FIRST_STEP]])

    def predict(self, u):
        """Predict the next step from the voltages of the motors."""
        pose_1, pose_2 = self.x[:3], self.x[3:]
        cos, sin = np.cos(pose_1[2]), np.sin(pose_1[2])
        drive = b1 * u[0] + b2 * u[1] + d1
        # x = f(x, u)
        self.x = np.concatenate((a1 * pose_1 + a2 * pose_2 + drive * [cos, sin, 1], pose_1))
        # F = df/dx
        F = np.zeros((6, 6))
        F[:3, :3] = np.diag(a1)
        F[:3, 2] += drive * [-sin, cos, 0]
        F[:3, 3:] = np.diag(a2)
        F[3:, :3] = np.eye(3)
        # P = F P F' + Q
        self.P = F @ self.P @ F.T
        self.P[:3, :3] += self.Q

    def update(self, z):
        """Correct the prediction by a measurement."""
        # innovation = z - H x,  H = (1 0)
        innovation = self.innovation(z)
        # K = P H' (H P H' + R)^-1
        K = np.linalg.solve(self.P[:3, :3] + self.R, self.P[:3]).T
        self.x = self.x + K @ innovation
        # P = (1 - K H) P, kept symmetric
        P = self.P - K @ self.P[:3]
        self.P = (P + P.T) / 2

    def innovation(self, z):
        """Return measurement minus prediction."""
        innovation = z - self.x[:3]
        innovation[2] = wrap(innovation[2])
        return innovation
