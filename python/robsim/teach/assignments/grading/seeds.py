"""Which world each run of a test has: by key, student, test and number."""

from __future__ import annotations

from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.errors import AssignmentError
from robsim.teach.grading.keys import Key
from robsim.teach.grading.seeds import RunSeeds


def key_for(assignment: Assignment, *, public: bool) -> Key:
    """Return the key of tests that are public, or not; raise AssignmentError if there is none."""
    if public:
        return Key.public()
    if assignment.key is None:
        raise AssignmentError(
            f"{assignment.name} has no key, which the worlds of tests that are not public come "
            "from: bring back the file key, or write a new one with robsim.teach.Key.new()",
            file="key",
        )
    return assignment.key


def student_for(assignment: Assignment, student: str, *, public: bool) -> str:
    """Return the name that the key is asked with; "" = all have the same worlds."""
    return student if assignment.own_seeds and not public else ""


def seeds_of(assignment: Assignment, test: TaskTest, student: str, run: int) -> RunSeeds:
    return RunSeeds.of_key(
        key_for(assignment, public=test.public),
        student_for(assignment, student, public=test.public),
        f"{assignment.name}/{test.name}",
        run,
        test.task.steps,
    )
