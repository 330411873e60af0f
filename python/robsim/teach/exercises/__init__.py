"""Exercises of the notebooks: functions for students to write, and their checks."""

from robsim.teach.exercises.checking import check_answer, checked
from robsim.teach.exercises.exercise import Exercise
from robsim.teach.exercises.shipped import copy_notebooks, notebook_exercises

__all__ = ["Exercise", "check_answer", "checked", "copy_notebooks", "notebook_exercises"]
