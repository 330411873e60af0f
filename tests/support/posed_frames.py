"""Frames of a robot at known poses, and what is measured in them."""

import functools

import numpy as np

import robsim

AREA = (600, 480)
SIZE = (300, 240)
POSES = ((150.0, 120.0, 0.3), (300.0, 240.0, -2.0), (450.0, 330.0, 1.4), (220.0, 350.0, 3.0))


@functools.cache
def frames():
    """Return a frame of the robot at each of `POSES`."""
    return tuple(_frame(pose) for pose in POSES)


def _frame(pose):
    sim = robsim.Simulation(area=AREA, resolution=SIZE, start=pose, measure=True, seed=1)
    sim.step()
    return sim.frame


def measured(frame):
    """Return the pose that is measured in a frame: array (3,)."""
    robot = robsim.load_robot("lab")
    blobs = robsim.find_blobs(frame, robsim.load_colors())
    return robsim.locate(blobs, robot.marker_layout(), plane_map=frame.plane_map).pose


def difference(frame, k):
    """Return how far the pose measured in a frame is off what it is in frame k in memory.

    In px of the work area, and rad.
    """
    off = measured(frame) - measured(frames()[k])
    return np.hypot(off[0], off[1]), abs(robsim.wrap_angle(off[2]))


def true_difference(frame, k):
    """Return the distance to the true position (px of the work area)."""
    return np.hypot(*(measured(frame)[:2] - POSES[k][:2]))
