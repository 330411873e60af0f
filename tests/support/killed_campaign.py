"""A program that kills itself in its campaign: ``python killed_campaign.py STORE``."""

import os
import signal
import sys

import robsim
from robsim.campaigns import campaign

OPTIONS = {
    "scenario": robsim.Scenario(area=(300, 300), start="random"),
    "runs": 1000,
    "steps": 5,
    "seed": 1,
    "progress": False,
}


def kills(trace):
    """Kill the program in run 700; not the tests, which import it."""
    if __name__ == "__main__" and trace.info.seed["spawn_key"][-1] == 700:
        os.kill(os.getpid(), signal.SIGKILL)
    return trace.pose_true[-1, 0]


if __name__ == "__main__":
    campaign(**OPTIONS, metrics=[kills], store=sys.argv[1])
