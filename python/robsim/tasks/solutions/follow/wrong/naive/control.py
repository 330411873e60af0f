"""Turns to the next waypoint and drives; knows no speed, and brakes for nothing."""

import numpy as np
from task import MAXIMUM_VOLTAGE, WAYPOINT_RADIUS, WAYPOINTS

import robsim

to_come = list(WAYPOINTS)


def control(step):
    if step.measurement is None:
        return 0.0, 0.0
    x, y, heading = step.measurement.pose
    if np.hypot(to_come[0][0] - x, to_come[0][1] - y) < WAYPOINT_RADIUS and len(to_come) > 1:
        del to_come[0]
    error = robsim.wrap_angle(np.arctan2(to_come[0][1] - y, to_come[0][0] - x) - heading)
    turn = np.clip(0.5 * error, -0.5, 0.5) * MAXIMUM_VOLTAGE
    drive = 0.5 * MAXIMUM_VOLTAGE * max(np.cos(error), 0)
    return drive + turn, drive - turn
