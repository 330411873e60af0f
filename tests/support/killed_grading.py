"""A class that is graded by a process that tests kill: FOLDER, SUBMISSIONS, OUT."""

import sys

from robsim.teach import Assignment
from small_assignments import drawn_quickly

if __name__ == "__main__":
    folder, submissions, out = sys.argv[1:]
    with drawn_quickly():
        Assignment.load(folder).grade_class(submissions, out)
