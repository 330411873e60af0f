"""Estimates of parameters and states, their quality, and reference filters for comparison."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from robsim.base.doors import late_names as _late_names

if _TYPE_CHECKING:
    from robsim.estimation.evaluation import *
    from robsim.estimation.identification import *

__getattr__, __dir__ = _late_names(__name__, ("identification", "evaluation"), apart=("reference",))
