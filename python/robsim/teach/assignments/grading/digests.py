"""What numbers rest on, as digests: the same again is not run again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from robsim.teach.assignments.assignment import Assignment, FileTests, TaskTest
from robsim.teach.submissions import SubmissionFiles
from robsim.teach.tasks.solutions import module_source

_FORMAT = "robsim grading 1"


def of_submission(files: SubmissionFiles) -> str:
    return hashlib.sha256(files.to_message()).hexdigest()


def of_test(assignment: Assignment, test: TaskTest | FileTests) -> str:
    """Return the digest of what the numbers of a test rest on: points and limits are no part."""
    rules = {
        "name": assignment.name,
        "slots": assignment.slots,
        "functions": assignment.functions,
        "imports": assignment.imports,
        "masked": assignment.masked,
        "given": assignment.given,
        "given files": _of_files(assignment.files_of_all),
        "own seeds": assignment.own_seeds,
        "limits": asdict(assignment.limits),
        "seconds": assignment.seconds,
    }
    own = _of_task(test) if isinstance(test, TaskTest) else _of_file(test)
    key = None if test.public or assignment.key is None else assignment.key.pseudonym("its digest")
    return _of([_FORMAT, rules, own, test.public, key])


def of_assignment(assignment: Assignment) -> str:
    """Return the digest of what all its points rest on."""
    marks = [
        [test.name, test.points, {name: asdict(limit) for name, limit in test.limits.items()}]
        for test in assignment.tests
    ]
    tests = [of_test(assignment, test) for test in assignment.all_tests]
    return _of([tests, marks])


def _of_task(test: TaskTest) -> list[Any]:
    reference = {} if test.reference is None else _of_files(test.reference.files)
    known = {name: list(values) for name, values in test.reference_values.items()}
    task = test.task
    return [test.name, repr(task), module_source(task).hex(), reference, known]


def _of_file(test: FileTests) -> list[Any]:
    return [test.path.name, hashlib.sha256(test.path.read_bytes()).hexdigest()]


def _of_files(files: Mapping[str, bytes]) -> dict[str, str]:
    return {name: hashlib.sha256(content).hexdigest() for name, content in sorted(files.items())}


def _of(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, default=repr).encode()).hexdigest()
