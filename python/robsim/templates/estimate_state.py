"""Where the robot is, by all that is known, and how sure that is.

Called at every step, after the measurement. Gets `step`, of which you need:
    step.measurement   what measure returned: step.measurement.pose is x, y (px), heading (rad).
                       None: not seen, or ENABLED = False in measure.py
    step.parameters    what estimate_parameters returned last, (3, 5), or None
    step.u, step.dt    the last voltages: left, right motor (V); the time between two steps (s)
Returns an Estimate: the pose, x, y (px), heading (rad), and its covariance, (3, 3).
"""

from types import SimpleNamespace

import numpy as np

import robsim

ENABLED = False  # True: this stage is on

# Variances of x, y (px^2) and of the heading (rad^2).
MEASURED = np.diag((0.5**2, 0.5**2, 0.01**2))  # of a measurement
ONE_STEP = np.diag((5.0**2, 5.0**2, 0.05**2))  # what a step without a measurement adds
AT_FIRST = np.diag((600.0**2, 600.0**2, 2.0**2))  # of the first guess

memory = SimpleNamespace(pose=(600.0, 600.0, 0.0), covariance=AT_FIRST)


def estimate_state(step):
    """Keep the last measured pose, and doubt it more with every step without a new one."""
    if step.k == 0:  # a run begins: the middle of the work area is a guess like any other
        memory.pose, memory.covariance = (600.0, 600.0, 0.0), AT_FIRST
    if step.measurement is not None:
        memory.pose, memory.covariance = step.measurement.pose, MEASURED
    else:
        memory.covariance = memory.covariance + ONE_STEP
    # To try: doubt it the more, the faster the wheels turn.
    # memory.covariance = memory.covariance + step.u @ step.u * ONE_STEP
    return robsim.Estimate(memory.pose, memory.covariance)
