"""An example of your own tests: plain pytest, in which `submission` is a student's submission.

Each function has points, and a sentence for a failure. Write others, or remove this file and
its lines in assignment.toml.
"""

import numpy as np
import pytest

import robsim

STILL = robsim.Scenario(
    robot="lab",
    resolution=(400, 400),
    boundary="unlimited",
    control=robsim.Replay(np.zeros((40, 2))),
    measure=True,
    identify_from="measurement",
)


@pytest.mark.points(1, failure="Samples of a robot at rest have no information on its motors.")
def test_a_robot_at_rest_leaves_the_motors_as_they_are(submission):
    trace = submission.run(STILL, steps=40, seed=1)
    gains = trace.parameters[:, :, 2:4]
    known = gains[np.isfinite(gains).all(axis=(1, 2))]  # empty before the first sample
    assert len(known) > 30
    assert np.allclose(known[-1], known[0], atol=0.05)
