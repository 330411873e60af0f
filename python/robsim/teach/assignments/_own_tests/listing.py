"""The tests in a teacher's file, with their points."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robsim.base.text import one_line
from robsim.teach.assignments.assignment import Assignment, FileTests
from robsim.teach.errors import AssignmentError
from robsim.teach.results import ERROR, NOT_RUN, TestResult
from robsim.teach.submissions.reading import Contents
from robsim.teach.texts import clean_text


@dataclass(frozen=True, kw_only=True)
class OwnTest:
    """A function of a file for pytest that is a test of an assignment."""

    name: str  # its name, for pytest
    title: str  # the first line of its docstring, else its name
    points: float  # for passing
    public: bool  # whether students get it
    success: str = ""  # the sentence for the student; "" = the default
    failure: str = ""

    def result(self, **told: Any) -> TestResult:
        told.setdefault("points", 0.0)
        told |= {"title": self.title, "public": self.public, "most": self.points}
        return TestResult(name=self.name, **told)


_CHILD = "robsim.teach.assignments._own_tests.child"
_LISTING = 60.0  # s
_OUT_OF_TIME = "not run: out of time"
_SAID = 600  # characters of a failed child's last output


def list_own_tests(assignment: Assignment, test: FileTests) -> tuple[OwnTest, ...]:
    """Return the tests in a file without running them.

    Raise AssignmentError if pytest cannot load the file, or if the points are invalid.
    """
    with _child(assignment, test, None, "", _LISTING) as (lines, status, said):
        found = tuple(OwnTest(**data) for kind, data in lines if kind == "test")
        if status != 0 or not found:
            broken = [data["text"] for kind, data in lines if kind == "broken"]
            what = broken[0] if broken else "it has no tests" if status == 5 else said
            name = test.path.name
            raise AssignmentError(f"{one_line(name)} cannot be used: {what}", file=name)
        return found


def run_own_tests(
    assignment: Assignment,
    test: FileTests,
    own: tuple[OwnTest, ...],
    contents: Contents,
    student: str,
    seconds: float,
    digest: str,
) -> tuple[TestResult, ...]:
    """Run a file for a submission, with a time limit (s); return a result for each test."""
    with _child(assignment, test, contents, student, seconds) as (lines, status, said):
        done = {data.pop("name"): data for kind, data in lines if kind == "result"}
        other = {"status": NOT_RUN, "sentence": _OUT_OF_TIME}
        if status is not None:
            text = f"the tests of {test.path.name} have ended early: {said}"
            other |= {"status": ERROR, "sentence": text, "whose": AssignmentError.whose}
        return tuple(one.result(**done.get(one.name, other), digest=digest) for one in own)


@contextmanager
def _child(
    assignment: Assignment, test: FileTests, contents: Contents | None, student: str, seconds: float
) -> Iterator[tuple[list[tuple[str, dict[str, Any]]], int | None, str]]:
    """Yield a child's messages, its exit status (None = out of time) and its last output."""
    with tempfile.TemporaryDirectory(prefix="robsim-tests-") as folder:
        out = Path(folder, "results")
        request = {
            "folder": str(assignment.folder),
            "file": assignment.files.index(test),
            "isolation": assignment.isolation,
            "submission": contents and str(contents.written_to(Path(folder, "handed in"))),
            "student": student,
            "out": str(out),
        }
        work = Path(folder, "work")
        work.mkdir()
        status, said = _run(request, work, seconds)
        yield list(_told(out)), status, said


def _run(request: dict[str, Any], folder: Path, seconds: float) -> tuple[int | None, str]:
    child = subprocess.Popen(
        [sys.executable, "-P", "-m", _CHILD],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        cwd=folder,
        start_new_session=True,
        env={**os.environ, "PYTEST_ADDOPTS": "", "PYTEST_PLUGINS": ""},
    )
    try:
        said, _ = child.communicate(json.dumps(request).encode() + b"\n", timeout=seconds)
        text = said[-8 * _SAID :].decode("utf-8", "replace").strip()
        return child.returncode, clean_text(text[-_SAID:]) or "without output"
    except subprocess.TimeoutExpired:
        return None, ""
    finally:
        _end(child)


def _end(child: subprocess.Popen[bytes]) -> None:
    if child.poll() is None:
        with suppress(OSError):
            if sys.platform == "win32":
                child.kill()  # its workers end, too
            else:
                os.killpg(child.pid, signal.SIGKILL)
    child.communicate()


def _told(out: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    try:
        text = out.read_text(encoding="utf-8")
    except FileNotFoundError:
        return
    for line in text.splitlines(keepends=True):
        if line.endswith("\n"):
            data = json.loads(line)
            yield data.pop("kind"), data
