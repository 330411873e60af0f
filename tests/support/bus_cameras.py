"""Labs on the virtual FireWire bus, and whether what comes from it is right."""

import numpy as np

import robsim

LARGE = (640, 480)
SIZE = (320, 240)


def new_lab(size=SIZE, fps=30):
    """Return a lab whose robot is in the middle of its floor."""
    scenario = robsim.Scenario(seed=3, area=size, resolution=size)
    return robsim.lab.SimulatedLab(scenario, fps=fps)


def true_pose(lab, frame):
    """Return where the robot was when a frame was exposed, which the bus counts in 125 us."""
    truth = lab.truth
    exposed = frame.epoch + frame.t
    tick = int(np.argmin(np.abs(truth.t - exposed)))
    assert abs(truth.t[tick] - exposed) < 2e-3
    return truth.pose[tick]


def error_of(lab, frame):
    """Return how far from the truth the robot is seen (px)."""
    layout = lab.scenario._marker_layout
    blobs = robsim.find_blobs(frame, robsim.load_colors(), markers=layout)
    seen = robsim.locate(blobs, layout, plane_map=frame.plane_map)
    assert seen is not None, "the robot is not seen"
    return float(np.hypot(*(seen.pose[:2] - true_pose(lab, frame)[:2])))
