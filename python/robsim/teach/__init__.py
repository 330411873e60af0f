"""Teaching: tasks, checks, grading, and assignments."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from robsim.base.doors import late_names as _late_names

if _TYPE_CHECKING:
    from robsim.teach.assignments import *
    from robsim.teach.doctor import *
    from robsim.teach.exercises import *
    from robsim.teach.grading import *
    from robsim.teach.tasks import *

__getattr__, __dir__ = _late_names(
    __name__, ("tasks", "doctor", "grading", "exercises", "assignments"), apart=("gym",)
)
