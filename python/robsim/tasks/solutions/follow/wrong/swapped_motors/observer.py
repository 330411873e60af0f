"""Where the robot is and how fast it moves, also while nobody sees it."""

import numpy as np

import robsim

THETA = robsim.RobotModel().theta
GAIN, VELOCITY_GAIN = 0.6, 0.15


class Observer:
    def __init__(self):
        self.pose, self.velocity, self.is_known = np.zeros(3), np.zeros(3), False

    def update(self, step):
        if self.is_known:
            self.predict(step.last_u)
        if step.measurement is None:
            return
        measured = np.array(step.measurement.pose)
        if not self.is_known:
            self.pose, self.is_known = measured, True
            return
        error = measured - self.pose
        error[2] = robsim.wrap_angle(error[2])
        self.pose = self.pose + GAIN * error
        self.velocity = self.velocity + VELOCITY_GAIN * error

    def predict(self, u):
        # v(k) = -a2 v(k-1) + b1 u1 + b2 u2, the force of x and y along the heading
        heading = self.pose[2]
        force = THETA[:, 2] * u[0] + THETA[:, 3] * u[1]
        direction = np.array([np.cos(heading), np.sin(heading), 1.0])
        self.velocity = -THETA[:, 1] * self.velocity + force * direction
        self.pose = self.pose + self.velocity
