"""The robot's pose and velocity from measurements alone, without a model."""

import numpy as np

import robsim

SMOOTHING = 2.5  # steps


class Motion:
    def __init__(self):
        self.pose, self.velocity, self.is_known = np.zeros(3), np.zeros(3), False
        self.k, self.seen = 0, np.zeros(3)

    def update(self, step):
        if step.measurement is None:
            self.pose = self.pose + self.velocity  # as before, until it is seen again
            return
        measured = np.array(step.measurement.pose)
        if self.is_known:
            moved = measured - self.seen
            moved[2] = robsim.wrap_angle(moved[2])
            steps = step.k - self.k
            self.velocity = self.velocity + (moved - steps * self.velocity) / (steps + SMOOTHING)
        self.pose, self.seen, self.k, self.is_known = measured, measured, step.k, True
