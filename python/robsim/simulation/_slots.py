"""The slots of the loop."""

from __future__ import annotations

#: Each slot and the argument that its callback gets: those called once, at the start ...
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

#: Slots that a run can do without.
OPTIONAL = ("estimate_parameters", "measure", "estimate_state")

#: Slots that take True for robsim's own stage.
SWITCHES = ("estimate_parameters", "measure")
