"""The doctor: checks that say what is wrong with a callback, and in which line."""

from robsim._base.check_report import CheckReport, Problem
from robsim._base.public import present as _present
from robsim._base.source_line import SourceLine
from robsim.doctor._callbacks.backgrounds import check_background
from robsim.doctor._callbacks.controllers import check_controller
from robsim.doctor._callbacks.folder import FolderReport, check_folder
from robsim.doctor._callbacks.measurements import check_measurement
from robsim.doctor._callbacks.models import check_model, check_motion
from robsim.doctor._parameter_estimators import check_parameter_estimator
from robsim.doctor._state_estimators import check_estimator
from robsim.doctor._tasks.report import TaskReport

__all__ = [
    "CheckReport",
    "FolderReport",
    "Problem",
    "SourceLine",
    "TaskReport",
    "check_background",
    "check_controller",
    "check_estimator",
    "check_folder",
    "check_measurement",
    "check_model",
    "check_motion",
    "check_parameter_estimator",
]

_present(globals())
