"""The panels of a run: in a notebook or in a browser window."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from robsim.base.doors import late_names as _late_names

if _TYPE_CHECKING:
    from robsim.gui.names import *

__getattr__, __dir__ = _late_names(__name__, ("names",))
