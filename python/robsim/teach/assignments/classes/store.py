"""The files of a graded class: existing results are not computed again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from pkgutil import resolve_name
from types import MappingProxyType, ModuleType

import numpy as np

from robsim.base.files import write_whole
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.assignment_file import solutions_for
from robsim.teach.assignments.classes.submissions import submissions_in
from robsim.teach.errors import SubmissionError
from robsim.teach.reports.gradescope import write_gradescope
from robsim.teach.reports.similarity import EARLIER_YEAR, Program, program_of
from robsim.teach.reports.writing import RESULT, folder_name, write_class, write_student
from robsim.teach.results import ByHand, SubmissionResult, TestResult
from robsim.teach.submissions.copies import codes_of, codes_of_files
from robsim.teach.submissions.reading import open_submission
from robsim.teach.tasks.solutions import MODULE, module_source

PATHS = "paths.json"
_MOST = 2**26  # bytes


#: The marks by hand of a submission, and the points that a teacher gives.
Marks = tuple[ByHand, tuple[TestResult, ...]]


@dataclass
class ResultFolder:
    """The folders of results, and optionally the file that Gradescope reads."""

    folder: Path
    gradescope: Path | None = None
    leaderboard: str = ""
    teacher_pages: bool = False
    columns: str = "robsim"
    pseudonym: Callable[[str], str] | None = None
    by_hand: Mapping[str, Marks] = field(default_factory=dict)  # by student

    def of(self, student: str) -> Path:
        return self.folder / folder_name(student)

    def read(self, student: str) -> SubmissionResult | None:
        """Return the result of a submission; None = missing or unreadable."""
        try:
            text = (self.of(student) / RESULT).read_bytes()[:_MOST].decode()
            return SubmissionResult.from_json(text)
        except (OSError, ValueError):
            return None

    def students(self) -> list[str]:
        return sorted(file.parent.name for file in self.folder.glob(f"*/{RESULT}"))

    def write(
        self,
        result: SubmissionResult,
        pictures: Mapping[str, bytes] = MappingProxyType({}),
        paths: Mapping[str, list[list[float]]] = MappingProxyType({}),
    ) -> SubmissionResult:
        """Write a result with its marks by hand, and return it."""
        by_hand, parts = self.by_hand.get(result.student, (ByHand(), ()))
        result = replace(result, by_hand=by_hand, tests=(*result.tests, *parts))
        place = self.of(result.student)
        place.mkdir(parents=True, exist_ok=True)
        if paths:
            known = {**self.paths(result.student), **paths}
            write_whole(place / PATHS, json.dumps(known).encode())
        write_student(place, result, pictures=pictures, teacher_page=self.teacher_pages)
        if self.gradescope is not None:
            files = {one.name: place / one.picture for one in result.tests if one.picture}
            there = {name: file.read_bytes() for name, file in files.items() if file.is_file()}
            board = self.leaderboard
            write_gradescope(self.gradescope, result, pictures=there, leaderboard=board)
        return result

    def paths(self, student: str) -> dict[str, list[list[float]]]:
        try:
            data = json.loads((self.of(student) / PATHS).read_bytes())
        except (OSError, ValueError, RecursionError):
            return {}
        return data if isinstance(data, dict) else {}


START = "start"  # the files for students to begin with
EARLIER = "earlier"  # submissions of earlier years


def write_class_files(
    assignment: Assignment,
    programs: Mapping[str, Program] | None,
    others: Mapping[str, Program],
    folder: ResultFolder,
    results: Sequence[SubmissionResult],
) -> None:
    """Write page and table of a class into the folder of its results, not for a single submission.

    If `programs` (by student) is None, the page shows the last comparison, from ``similar.json``;
    `others` come from `other_programs`.
    """
    if len(results) < 2:
        return
    area = assignment.tests[0].task.scenario.area if assignment.tests else (1200, 1200)
    found = {result.student: folder.paths(result.student) for result in results}
    write_class(
        folder.folder,
        results,
        paths={
            test.name: {
                student: np.asarray(paths[test.name], float)
                for student, paths in found.items()
                if test.name in paths
            }
            for test in assignment.tests
            if test.task.scenario.area == area
        },
        area=area,
        programs=programs,
        given=list(_given(assignment)),
        others=others,
        pseudonym=folder.pseudonym,
        columns=folder.columns,
    )


def _given(assignment: Assignment) -> Iterator[Program]:
    yield program_of(assignment.files_of_all)
    for test in assignment.tests:
        yield program_of({f"{MODULE}.py": module_source(test.task)})
    start = assignment.folder / START
    if start.is_dir():
        yield program_of({file.name: file.read_bytes() for file in sorted(start.glob("*.py"))})


def _masked_programs(masks: Iterable[str]) -> Iterator[tuple[str, Program]]:
    """Yield the Python files of masked modules, functions and classes of robsim."""
    for mask in masks:
        if mask.startswith("robsim.") and not mask.startswith("robsim.teach."):
            with suppress(ImportError, AttributeError):
                value = resolve_name(mask)
                is_module = isinstance(value, ModuleType)
                codes = codes_of_files(mask) if is_module else codes_of(value)
                files = sorted({Path(code.co_filename) for code in codes})
                sources = {file.name: file.read_bytes() for file in files}
                yield mask.replace(".", "/", 1), program_of(sources)


def other_programs(assignment: Assignment) -> dict[str, Program]:
    """Return possible sources of copies by their names on the page.

    These are robsim's masked code, the solutions of tasks, and the submissions in ``earlier/``:
    each entry is a submission or a folder of them. Raise AssignmentError or OSError as
    `submissions_in`.
    """
    found = dict(_masked_programs(assignment.masked))
    for task in {test.task.name: test.task for test in assignment.tests}.values():
        for one in (*task.solutions, *solutions_for(assignment.folder, task)):
            kind = "shipped solution" if one.folder is None else "solution"
            files = {f"{name}.py": source for name, source in one.files.items()}
            sources = one.notebook.sources if one.notebook else files
            if (program := program_of(sources)) not in found.values():  # as shipped
                found[f"{kind} {task.name}/{one.name}"] = program
    for entry in sorted((assignment.folder / EARLIER).glob("[!._]*")):
        for handed in submissions_in(entry, assignment):
            is_class = handed.files or handed.path != str(entry)
            name = f"{entry.name}/{handed.student}" if is_class else handed.student
            with suppress(SubmissionError):
                contents = open_submission(handed.path, assignment._rules(), handed.files)
                found[f"{EARLIER_YEAR}{name}"] = program_of(contents.files)
    return found
