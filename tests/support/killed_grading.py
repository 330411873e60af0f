"""A class that is graded by a process that tests kill: FOLDER, SUBMISSIONS, OUT."""

import sys

from robsim.teach import grade_class, load_assignment
from small_assignments import drawn_quickly

if __name__ == "__main__":
    folder, submissions, out = sys.argv[1:]
    with drawn_quickly():
        grade_class(load_assignment(folder), submissions, out)
