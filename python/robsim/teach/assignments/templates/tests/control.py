"""An example of your own tests: plain pytest, in which `submission` is a student's submission.

Each function has points, and a sentence for a failure. Write others, or remove this file and
its lines in assignment.toml.
"""

import pytest

import robsim

HIDDEN = robsim.Scenario(
    robot="lab",
    area=(800, 800),
    resolution=(400, 400),
    start="random",
    measure=True,
    dropout=robsim.Dropout(1),
)


@pytest.mark.points(1, failure="Before the first measurement the robot must stand: return 0, 0.")
def test_a_robot_that_nobody_sees_stands_still(submission):
    trace = submission.run(HIDDEN, steps=10, seed=1)
    assert abs(trace.u).max() == 0
