"""Names, arguments and order of the slots, for `Simulation` and the callback folders."""

from __future__ import annotations

#: Each slot and the argument of its callback: those called once, at the start ...
ONCE = {
    "define_model": "",
    "init_parameter_estimator": "model",
    "adjust_background": "background",
}
#: ... and those called at each step, in this order.
STEP = {
    "evaluate_model": "world",
    "estimate_parameters": "step",
    "measure": "step",
    "estimate_state": "step",
    "control": "step",
}
ARGUMENTS = ONCE | STEP

#: Slots that may stay empty.
OPTIONAL = ("estimate_parameters", "measure", "estimate_state")

#: Slots that accept True for the default stage.
SWITCHES = ("estimate_parameters", "measure")
