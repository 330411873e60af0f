"""The worlds of a test: seeds, the reference in them, and digests of the inputs of numbers."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from robsim.teach.assignments.assignment import RULES, Assignment, FileTests, TaskTest
from robsim.teach.errors import AssignmentError
from robsim.teach.grading.graded_run import all_here
from robsim.teach.grading.keys import Key, RunSeeds
from robsim.teach.grading.task import Task as GradedTask
from robsim.teach.submissions import Rules, SubmissionFiles
from robsim.teach.submissions.files import FOLDER
from robsim.teach.tasks.solutions import MODULE, module_source
from robsim.trace import Trace


def key_for(assignment: Assignment, *, public: bool) -> Key:
    """Return the key of public or hidden tests; raise AssignmentError without a key."""
    if public:
        return Key.public()
    if assignment.key is None:
        raise AssignmentError(
            f"{assignment.name} has no key, which determines the worlds of hidden tests: "
            "restore the file key, or write a new key with robsim.teach.Key.new()",
            file="key",
        )
    return assignment.key


def student_for(assignment: Assignment, student: str, *, public: bool) -> str:
    """Return the student's name for the key; "" = all have the same worlds."""
    return student if assignment.own_seeds and not public else ""


def seeds_of(assignment: Assignment, test: TaskTest, student: str, run: int) -> RunSeeds:
    return RunSeeds.of_key(
        key_for(assignment, public=test.public),
        student_for(assignment, student, public=test.public),
        f"{assignment.name}/{test.name}",
        run,
        test.task.steps,
    )


class References:
    """Numbers of the references of an assignment, each computed once."""

    def __init__(self, assignment: Assignment) -> None:
        self._assignment = assignment
        self._kept: dict[tuple[str, str, int], Mapping[str, float]] = {}

    def numbers(self, test: TaskTest, student: str, run: int) -> Mapping[str, float]:
        """Return the reference's numbers in a run, by score; raise AssignmentError if it fails."""
        if test.public and test.reference_values:
            return {name: values[run] for name, values in test.reference_values.items()}
        known = student_for(self._assignment, student, public=test.public)
        place = (test.name, known, run)
        if place not in self._kept:
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
    return GradedTask(submission=files, rules=Rules(slots=test.task.slots, defaults=True))


def numbers_of(test: TaskTest, trace: Trace) -> Mapping[str, float]:
    try:
        numbers = test.task.score(trace)
        return {score.name: float(numbers[score.name]) for score in test.task.scores}
    except Exception as error:
        raise AssignmentError(
            f"a run of the test {test.name} cannot be scored: {type(error).__name__}: {error}"
        ) from error


_FORMAT = "robsim grading 1"


def of_submission(files: SubmissionFiles) -> str:
    return hashlib.sha256(files.to_message()).hexdigest()


def of_test(assignment: Assignment, test: TaskTest | FileTests) -> str:
    """Return the digest of the inputs of a test's numbers, without points and limits."""
    rules = {
        **{name: getattr(assignment, name) for name in ("name", *RULES, "given")},
        "given files": _of_files(assignment.files_of_all),
        "own seeds": assignment.own_seeds,
        "limits": asdict(assignment.limits),
        "seconds": assignment.seconds,
    }
    if isinstance(test, TaskTest):
        reference = {} if test.reference is None else _of_files(test.reference.files)
        known = {name: list(values) for name, values in test.reference_values.items()}
        source = module_source(test.task).hex()
        own = [test.name, repr(test.task), source, reference, known]
    else:
        own = [test.path.name, hashlib.sha256(test.path.read_bytes()).hexdigest()]
    key = None if test.public or assignment.key is None else assignment.key.pseudonym("its digest")
    return _of([_FORMAT, rules, own, test.public, key])


def of_assignment(assignment: Assignment) -> str:
    marks = [
        [test.name, test.points, {name: asdict(limit) for name, limit in test.limits.items()}]
        for test in assignment.tests
    ]
    tests = [of_test(assignment, test) for test in assignment.all_tests]
    return _of([tests, marks])


def _of_files(files: Mapping[str, bytes]) -> dict[str, str]:
    return {name: hashlib.sha256(content).hexdigest() for name, content in sorted(files.items())}


def _of(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, default=repr).encode()).hexdigest()
