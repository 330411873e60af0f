"""Images and their content: frames, noise, calibrations, colours, blobs, poses, robots."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from robsim.base.doors import late_names as _late_names

if _TYPE_CHECKING:
    from robsim.vision.imaging import *
    from robsim.vision.markers import *
    from robsim.vision.robots import *

__getattr__, __dir__ = _late_names(__name__, ("imaging", "markers", "robots"))
