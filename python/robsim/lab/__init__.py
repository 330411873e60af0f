"""The hardware side: cameras, motors, calibration, rehearsal."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from robsim.base.doors import late_names as _late_names

if _TYPE_CHECKING:
    from robsim.lab.calibration import *
    from robsim.lab.cameras import *
    from robsim.lab.motors import *
    from robsim.lab.rehearsal import *

__getattr__, __dir__ = _late_names(__name__, ("cameras", "motors", "calibration", "rehearsal"))
