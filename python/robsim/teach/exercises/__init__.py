"""Exercises of the notebooks: functions that students write, and what is wrong with them."""

from robsim.teach.exercises.checking import check_answer, checked
from robsim.teach.exercises.exercise import Exercise
from robsim.teach.exercises.shipped import notebook_exercises

__all__ = ["Exercise", "check_answer", "checked", "notebook_exercises"]
