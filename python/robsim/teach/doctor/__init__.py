"""The doctor: checks that find the problems of a callback and their source lines."""

from robsim.base.check_report import CheckReport, Problem
from robsim.base.source_line import SourceLine
from robsim.teach.doctor.callbacks.backgrounds import check_background
from robsim.teach.doctor.callbacks.controllers import check_controller
from robsim.teach.doctor.callbacks.folder import FolderReport
from robsim.teach.doctor.callbacks.measurements import check_measurement
from robsim.teach.doctor.callbacks.models import check_model, check_motion
from robsim.teach.doctor.checking import check_folder
from robsim.teach.doctor.parameter_estimators import check_parameter_estimator
from robsim.teach.doctor.state_estimators import check_estimator
from robsim.teach.doctor.task_checks.report import TaskReport

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
