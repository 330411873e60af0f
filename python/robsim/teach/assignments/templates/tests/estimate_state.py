"""An example of your own tests: plain pytest, in which `submission` is a student's submission.

Each function has points, and a sentence for a failure. Write others, or remove this file and
its lines in assignment.toml.
"""

import numpy as np
import pytest

import robsim

HIDDEN = robsim.Scenario(
    robot="lab",
    resolution=(400, 400),
    start="random",
    control=robsim.DriveAround(),
    measure=True,
    dropout=robsim.Dropout(0.5, steps=5),
)


@pytest.mark.points(1, failure="While the robot is hidden, its estimate gets less certain.")
def test_an_estimate_without_measurements_gets_less_certain(submission):
    trace = submission.run(HIDDEN, steps=40, seed=1)
    area = np.linalg.det(trace.covariance[:, :2, :2])
    later = np.flatnonzero(~trace.seen[1:] & trace.seen.cumsum()[:-1].astype(bool)) + 1
    assert (area[later] > area[later - 1]).all()
