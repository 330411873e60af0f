"""How much is tried: little each time, much in ``./run thorough``."""

import os


def thorough(large, small):
    """Return the large size where ROBSIM_THOROUGH is set, else the small one."""
    return large if os.environ.get("ROBSIM_THOROUGH") else small
