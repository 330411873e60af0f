"""The reference of a test, run in the same worlds as a submission."""

from __future__ import annotations

from collections.abc import Mapping

from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.grading.seeds import seeds_of, student_for
from robsim.teach.errors import AssignmentError
from robsim.teach.grading.graded_run import all_here
from robsim.teach.grading.tasks.task import Task as GradedTask
from robsim.teach.submissions import Rules, SubmissionFiles
from robsim.teach.submissions.files import FOLDER
from robsim.teach.tasks.solutions import MODULE, module_source
from robsim.trace import Trace

_MOST_KEPT = 10_000  # runs


class References:
    """Numbers of the references of an assignment, each computed once.

    Parameters
    ----------
    assignment : Assignment
        The assignment.
    """

    def __init__(self, assignment: Assignment) -> None:
        self._assignment = assignment
        self._kept: dict[tuple[str, str, int], Mapping[str, float]] = {}

    def numbers(self, test: TaskTest, student: str, run: int) -> Mapping[str, float]:
        """Return the numbers of a run of the reference, by score.

        Raises
        ------
        AssignmentError
            If it fails, or there is none.
        """
        if test.public and test.reference_values:
            return {name: values[run] for name, values in test.reference_values.items()}
        known = student_for(self._assignment, student, public=test.public)
        place = (test.name, known, run)
        if place not in self._kept:
            if len(self._kept) >= _MOST_KEPT:
                self._kept.clear()
            self._kept[place] = numbers_of(test, self.trace(test, student, run))
        return self._kept[place]

    def trace(self, test: TaskTest, student: str, run: int) -> Trace:
        """Return a run of the reference; raise AssignmentError if it fails."""
        if test.reference is None:
            raise AssignmentError(f"the test {test.name} has no reference")
        seeds = seeds_of(self._assignment, test, student, run)
        try:
            with all_here(_task(test), test.task.scenario, seeds) as simulation:
                return simulation.run(test.task.steps)
        except Exception as error:
            raise AssignmentError(
                f"the reference of the test {test.name} fails: {type(error).__name__}: {error}",
                file=test.reference.name,
            ) from error


def _task(test: TaskTest) -> GradedTask:
    assert test.reference is not None
    modules = {**test.reference.files, MODULE: module_source(test.task)}
    sources = {f"{name}.py": content for name, content in modules.items()}
    slots = tuple(slot for slot in test.task.slots if slot in modules)
    files = SubmissionFiles(test.reference.name, FOLDER, "", sources, slots)
    return GradedTask(submission=files, rules=Rules(slots=test.task.slots))


def numbers_of(test: TaskTest, trace: Trace) -> Mapping[str, float]:
    try:
        numbers = test.task.score(trace)
        return {score.name: float(numbers[score.name]) for score in test.task.scores}
    except Exception as error:
        raise AssignmentError(
            f"a run of the test {test.name} cannot be scored: {type(error).__name__}: {error}"
        ) from error
