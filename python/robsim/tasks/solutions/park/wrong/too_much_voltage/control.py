"""Gives more voltage than the motors may have."""

import numpy as np
from observer import Observer
from task import GOAL

import robsim

MAXIMUM_VOLTAGE = 2.0
NEAR, FAR = 11.0, 18.0  # px: below the one it turns on the spot, above the other it drives
SLOW = 1.0  # px per step
AHEAD = np.array([np.cos(GOAL[2]), np.sin(GOAL[2])])


class Parking:
    def __init__(self):
        self.robot = Observer()
        self.is_there = False

    def __call__(self, step):
        self.robot.update(step)
        if not self.robot.is_known:
            return 0.0, 0.0
        distance = np.hypot(*(GOAL[:2] - self.robot.pose[:2]))
        is_slow = np.hypot(*self.robot.velocity[:2]) < SLOW
        self.is_there = distance < FAR if self.is_there else distance < NEAR and is_slow
        if self.is_there:
            turn = self.turning(robsim.wrap_angle(GOAL[2] - self.robot.pose[2]))
            return turn, -turn
        return self.drive(self.force())

    def force(self):
        """Return what brings the robot to the velocity that it should have (V)."""
        to_goal = GOAL[:2] - self.robot.pose[:2]
        distance = np.hypot(*to_goal)
        to_point = to_goal - 0.2 * max(distance - 60, 0) * AHEAD
        # px per step: slower and slower, so that it can brake
        wanted = 0.08 * to_point
        wanted *= min(1, 8 / max(np.hypot(*wanted), 1e-9))
        return 0.5 * (wanted - self.robot.velocity[:2])

    def drive(self, force):
        error = robsim.wrap_angle(np.arctan2(force[1], force[0]) - self.robot.pose[2])
        is_backwards = abs(error) > np.pi / 2
        if is_backwards:
            error = robsim.wrap_angle(error + np.pi)
        turn = self.turning(error)
        drive = np.cos(error) * np.hypot(*force) * (-1 if is_backwards else 1)
        room = MAXIMUM_VOLTAGE - abs(turn)
        drive = np.clip(drive, -room, room)
        return drive + turn, drive - turn

    def turning(self, error):
        limit = 0.8 * MAXIMUM_VOLTAGE
        return np.clip(0.7 * error - 2 * self.robot.velocity[2], -limit, limit)


control = Parking()
