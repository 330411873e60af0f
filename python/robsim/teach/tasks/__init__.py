"""Tasks for students, and the scores of their runs."""

from robsim.teach.tasks.by_name import TASKS, task
from robsim.teach.tasks.definition import Task, solution_folder
from robsim.teach.tasks.kinds.estimate import EstimateTask
from robsim.teach.tasks.kinds.follow import FollowTask
from robsim.teach.tasks.kinds.identify import IdentifyTask
from robsim.teach.tasks.kinds.measure import MeasureTask
from robsim.teach.tasks.kinds.park import ParkTask
from robsim.teach.tasks.marks.calibrate import calibrate_task
from robsim.teach.tasks.marks.calibration import SolutionMarks, TaskCalibration
from robsim.teach.tasks.score import Score, ScoreLimit
from robsim.teach.tasks.solutions import Solution
from robsim.teach.tasks.trial import TaskTrial, try_solution

__all__ = [
    "TASKS",
    "EstimateTask",
    "FollowTask",
    "IdentifyTask",
    "MeasureTask",
    "ParkTask",
    "Score",
    "ScoreLimit",
    "Solution",
    "SolutionMarks",
    "Task",
    "TaskCalibration",
    "TaskTrial",
    "calibrate_task",
    "solution_folder",
    "task",
    "try_solution",
]
