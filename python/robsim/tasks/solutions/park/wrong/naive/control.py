"""Turns to the position and drives, the faster the farther it is; knows no speed and no heading."""

import numpy as np
from task import GOAL, MAXIMUM_VOLTAGE

import robsim


def control(step):
    if step.measurement is None:
        return 0.0, 0.0
    x, y, heading = step.measurement.pose
    distance = np.hypot(GOAL[0] - x, GOAL[1] - y)
    error = robsim.wrap_angle(np.arctan2(GOAL[1] - y, GOAL[0] - x) - heading)
    turn = np.clip(0.5 * error, -0.5, 0.5)
    drive = min(0.01 * distance, MAXIMUM_VOLTAGE - abs(turn)) * max(np.cos(error), 0)
    return drive + turn, drive - turn
