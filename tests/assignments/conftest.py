"""A class that is graded once for many tests, and a browser for the pages of grading."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from chromium_browser import running_chromium
from robsim.teach import Assignment, ClassResult, ScoreLimit, grade_class, load_assignment
from small_assignments import assignment, drawn_quickly, solution, work

RAISES = """
import numpy as np, robsim
def estimate_state(step):
    if step.k == 7:
        raise ValueError(f"at {step.k}")
    return robsim.Estimate((600.0, 600.0, 0.0), np.eye(3))
"""
#: Between the reference, whose statistic is 1, and a naive solution.
TIGHT = ScoreLimit(full=1.0001, zero=1.5)


@pytest.fixture(scope="module")
def chromium():
    """A running browser; tests without one are skipped."""
    yield from running_chromium()


@dataclass(frozen=True)
class GradedClass:
    """A class: s001 has the reference, s002 is naive, s003 raises an error in step 7."""

    assignment: Assignment
    submissions: Path
    out: Path
    result: ClassResult

    def of(self, student):
        """The result of a student."""
        return next(one for one in self.result.results if one.student == student)


@pytest.fixture(scope="session")
def graded_class(tmp_path_factory):
    """A class that was graded; who changes what is in its folders copies them first."""
    folder = tmp_path_factory.mktemp("class")
    hw3 = load_assignment(assignment(folder / "hw3"))
    tests = [
        replace(test, limits=dict(test.limits) | {"position": TIGHT, "heading": TIGHT})
        for test in hw3.tests
    ]
    hw3 = replace(hw3, tests=tuple(tests))
    solution(folder / "subs/s001")
    solution(folder / "subs/s002", "naive")
    (folder / "subs/s003").mkdir()
    (folder / "subs/s003/estimate_state.py").write_text(RAISES)
    with drawn_quickly():
        result = grade_class(hw3, folder / "subs", folder / "out")
    return GradedClass(hw3, folder / "subs", folder / "out", result)


@pytest.fixture
def ran(monkeypatch):
    """The tests that are run in this process: student and name."""
    ran = []
    true = work.run_task_test

    def counted(assignment, test, files, student, *others):
        ran.append((student, test.name))
        return true(assignment, test, files, student, *others)

    monkeypatch.setattr(work, "run_task_test", counted)
    return ran
