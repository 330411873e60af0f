"""What is wrong first with callbacks that come from anywhere, in a sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robsim._core import RobotModel
from robsim.base.check_report import CheckReport
from robsim.simulation.slots import RobotSlots
from robsim.teach.doctor.callbacks.controllers import check_controller
from robsim.teach.doctor.callbacks.folder import with_estimator
from robsim.teach.doctor.callbacks.measurements import check_measurement
from robsim.teach.doctor.callbacks.models import check_model
from robsim.teach.doctor.parameter_estimators import check_parameter_estimator
from robsim.teach.doctor.state_estimators import check_estimator

#: What makes the callbacks by slot, anew each time.
MakeAll = Callable[[], Mapping[str, Any]]


def first_finding(make: MakeAll, slots: Iterable[str]) -> str:
    """Return the first problem of callbacks, and where it is; "" = all are well.

    Parameters
    ----------
    make : callable
        Returns the callbacks by slot, anew each time.
    slots : iterable of str
        Those to be checked.
    """
    for slot in slots:
        if slot in _CHECKS and callable(make().get(slot)):
            report = _CHECKS[slot](make)
            if report.problems:
                first = report.problems[0]
                places = [text for text in (first.where, first.code) if text]
                return "\n".join([f"{slot}: {first.sentence}", *places])
    return ""


def _init_parameter_estimator(make: MakeAll) -> CheckReport:
    return check_parameter_estimator(lambda: make()["init_parameter_estimator"](RobotModel()))


def _estimate_parameters(make: MakeAll) -> CheckReport:
    if not callable(make().get("init_parameter_estimator")):
        return check_parameter_estimator(lambda: make()["estimate_parameters"])

    def both() -> Any:
        callbacks = make()
        own = callbacks["init_parameter_estimator"]
        return with_estimator(callbacks["estimate_parameters"], lambda: own)

    return check_parameter_estimator(both)


_CHECKS: Mapping[str, Callable[[MakeAll], CheckReport]] = {
    RobotSlots.define_model.name: lambda make: check_model(lambda: make()["define_model"]),
    RobotSlots.estimate_parameters.name: _estimate_parameters,
    RobotSlots.init_parameter_estimator.name: _init_parameter_estimator,
    RobotSlots.measure.name: lambda make: check_measurement(lambda: make()["measure"]),
    RobotSlots.estimate_state.name: lambda make: check_estimator(lambda: make()["estimate_state"]),
    RobotSlots.control.name: lambda make: check_controller(lambda: make()["control"]),
}
