"""Tasks: what students are asked to do, and how a run of it is scored."""

from robsim.teach.tasks.by_name import TASKS, task
from robsim.teach.tasks.definition import Task, solution_folder
from robsim.teach.tasks.kinds.estimate import Estimate
from robsim.teach.tasks.kinds.follow import Follow
from robsim.teach.tasks.kinds.identify import Identify
from robsim.teach.tasks.kinds.measure import Measure
from robsim.teach.tasks.kinds.park import Park
from robsim.teach.tasks.marks.calibrate import calibrate
from robsim.teach.tasks.marks.calibration import SolutionMarks, TaskCalibration
from robsim.teach.tasks.score import Limit, Score
from robsim.teach.tasks.solutions import Solution
from robsim.teach.tasks.trial import TaskTrial, try_solution

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
    "solution_folder",
    "task",
    "try_solution",
]
