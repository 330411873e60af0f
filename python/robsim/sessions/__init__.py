"""Recorded runs: folders of frames, times, inputs and set-up, to be run again and looked at."""

from robsim._base.public import present as _present
from robsim.sessions._session import Session

__all__ = ["Session"]

_present(globals())
