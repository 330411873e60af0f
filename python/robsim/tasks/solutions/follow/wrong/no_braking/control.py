"""Drives by the distance alone, whatever the speed is."""

import numpy as np
from observer import Observer
from task import MAXIMUM_VOLTAGE, WAYPOINT_RADIUS, WAYPOINTS

import robsim

SPEED = 7.0  # px per step
SMALL = 0.15  # V: less is not worth a turn


class Follower:
    def __init__(self):
        self.robot = Observer()
        self.corners = None

    def __call__(self, step):
        self.robot.update(step)
        if not self.robot.is_known:
            return 0.0, 0.0
        if self.corners is None:
            self.corners = [self.robot.pose[:2], *map(np.array, WAYPOINTS)]
        distance = np.hypot(*(self.corners[1] - self.robot.pose[:2]))
        if distance < 0.8 * WAYPOINT_RADIUS and len(self.corners) > 2:
            del self.corners[0]
        return self.drive(0.5 * self.wanted())

    def wanted(self):
        """Return the velocity along the line and back to it (px per step)."""
        start, end = self.corners[:2]
        along = (end - start) / max(np.hypot(*(end - start)), 1e-9)
        to_end = end - self.robot.pose[:2]
        beside = to_end - (to_end @ along) * along
        # slower and slower, so that it can brake
        ahead = np.clip(0.08 * (to_end @ along), -SPEED, SPEED)
        return ahead * along + 0.08 * beside

    def drive(self, force):
        if np.hypot(*force) < SMALL:
            return 0.0, 0.0
        error = robsim.wrap_angle(np.arctan2(force[1], force[0]) - self.robot.pose[2])
        is_backwards = abs(error) > np.pi / 2
        if is_backwards:
            error = robsim.wrap_angle(error + np.pi)
        turn = np.clip(0.7 * error - 2 * self.robot.velocity[2], -0.8, 0.8) * MAXIMUM_VOLTAGE
        room = MAXIMUM_VOLTAGE - abs(turn)
        drive = np.cos(error) * np.hypot(*force) * (-1 if is_backwards else 1)
        drive = np.clip(drive, -room, room)
        return drive + turn, drive - turn


control = Follower()
