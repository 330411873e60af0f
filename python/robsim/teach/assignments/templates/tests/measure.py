"""An example of your own tests: plain pytest, in which `submission` is a student's submission.

Each function has points, and a sentence for a failure. Write others, or remove this file and
its lines in assignment.toml.
"""

import pytest

import robsim

HIDDEN = robsim.Scenario(
    robot="lab",
    resolution=(400, 400),
    start="random",
    control=robsim.DriveAround(),
    measure=True,
    dropout=robsim.Dropout(1),
)


@pytest.mark.points(1, failure="Return None if the robot cannot be seen.")
def test_a_hidden_robot_has_no_pose(submission):
    trace = submission.run(HIDDEN, steps=10, seed=1)
    assert not trace.seen.any()
