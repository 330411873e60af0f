"""Reports of grading: pages, tables and files, for students, teachers and platforms."""

from robsim.assignments._reports.marks.gradescope import gradescope, write_gradescope
from robsim.assignments._reports.marks.tables import marks_table
from robsim.assignments._reports.similarity.winnowing import Program, program_of
from robsim.assignments._reports.student_text import student_text
from robsim.assignments._reports.views import for_student
from robsim.assignments._reports.writing import write_class, write_student

__all__ = [
    "Program",
    "for_student",
    "gradescope",
    "marks_table",
    "program_of",
    "student_text",
    "write_class",
    "write_gradescope",
    "write_student",
]
