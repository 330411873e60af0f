"""The process that runs a file of a teacher's tests.

``python -m robsim.teach.assignments._own_tests.child`` is told what to do by a line of JSON: the
folder of the assignment, the number of the file, the submission, the student, the file for the
results.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import pytest

from robsim.teach.assignments._own_tests.plugin import Points
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.assignment_file import load_assignment
from robsim.teach.assignments.grading.references import key_for, student_for


def main() -> int:
    """Do it, and return the exit status of pytest."""
    request: dict[str, Any] = json.loads(sys.stdin.readline())
    assignment = load_assignment(request["folder"], isolation=request["isolation"])
    test = assignment.files[request["file"]]
    path = request["submission"]
    arguments = [f"--rootdir={assignment.folder}", "-c", os.devnull, "-p", "no:cacheprovider"]
    arguments += ["-q", "--strict-markers", "--no-header", "--disable-warnings"]
    options: dict[str, Any] = {}
    key = None
    if path is None:
        arguments.append("--collect-only")
    else:
        arguments += [f"--robsim-submission={path}", f"--robsim-isolation={assignment.isolation}"]
        key = key_for(assignment, public=test.public)
        student = student_for(assignment, request["student"], public=test.public)
        options = _options(assignment) | {"student": student}
    with open(request["out"], "w", encoding="utf-8") as out:
        plugin = Points(out, public=test.public, key=key, options=options)
        return pytest.main([*arguments, str(test.path)], plugins=[plugin])


def _options(assignment: Assignment) -> dict[str, Any]:
    return {
        "slots": assignment.slots,
        "functions": assignment.functions,
        "imports": assignment.imports,
        "masked": assignment.masked,
        "frames": assignment._frames,
        "limits": assignment.limits,
        "given": assignment.files_of_all,
    }


if __name__ == "__main__":
    raise SystemExit(main())
