"""Reports of grading: pages, tables and files, for students, teachers and platforms."""

from robsim.teach.reports.gradescope import gradescope, write_gradescope
from robsim.teach.reports.similarity import Program, program_of
from robsim.teach.reports.student_text import for_student, student_text
from robsim.teach.reports.tables import marks_table
from robsim.teach.reports.writing import write_class, write_student

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
