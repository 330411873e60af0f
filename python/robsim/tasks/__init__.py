"""Tasks: what students are asked to do, and how a run of it is scored."""

from robsim._base.public import present as _present
from robsim.tasks._by_name import TASKS, task
from robsim.tasks._kinds.estimate import Estimate
from robsim.tasks._kinds.follow import Follow
from robsim.tasks._kinds.identify import Identify
from robsim.tasks._kinds.measure import Measure
from robsim.tasks._kinds.park import Park
from robsim.tasks._limit import Limit
from robsim.tasks._marks.calibrate import calibrate
from robsim.tasks._marks.calibration import SolutionMarks, TaskCalibration
from robsim.tasks._score import Score
from robsim.tasks._solutions import Solution
from robsim.tasks._task import Task
from robsim.tasks._trial import TaskTrial

__all__ = [
    "TASKS",
    "Estimate",
    "Follow",
    "Identify",
    "Limit",
    "Measure",
    "Park",
    "Score",
    "Solution",
    "SolutionMarks",
    "Task",
    "TaskCalibration",
    "TaskTrial",
    "calibrate",
    "task",
]

_present(globals())
