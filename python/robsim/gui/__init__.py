"""The face: panels of a run in a notebook, or in a browser window of their own."""

from robsim._base.public import present as _present
from robsim.gui._facade import Panel, panel

__all__ = ["Panel", "panel"]

_present(globals())
