"""The files of a class: its page, tables of marks, what resembles what."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from robsim.base.checks import Floats
from robsim.teach.assignments.assignment import Assignment
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import Handed
from robsim.teach.assignments.grading.seeds import key_for
from robsim.teach.assignments.results import SubmissionResult
from robsim.teach.errors import SubmissionError
from robsim.teach.reports.similarity.winnowing import Program, program_of
from robsim.teach.reports.writing import write_class
from robsim.teach.submissions import read_submission
from robsim.teach.tasks.solutions import MODULE, module_source

START = "start"  # what students begin with


@dataclass(frozen=True, kw_only=True)
class ClassTables:
    """How the tables of a class look.

    Attributes
    ----------
    columns, title : str
        Columns of which learning platform, and the heading of that of points there.
    pseudonyms : bool
        Whether nobody's name is to be seen.
    """

    columns: str = "robsim"
    title: str | None = None
    pseudonyms: bool = False


def write_class_files(
    assignment: Assignment,
    handed: Iterable[Handed] | None,
    folder: ResultFolder,
    results: Sequence[SubmissionResult],
    tables: ClassTables,
) -> None:
    """Write page and table of a class into the folder of its results.

    Without what was `handed` in nothing is said of programs that resemble each other.
    """
    area = assignment.tests[0].task.scenario.area if assignment.tests else (1200, 1200)
    write_class(
        folder.folder,
        results,
        paths=_paths(assignment, folder, results, area),
        area=area,
        programs=None if handed is None else dict(_programs(assignment, handed)),
        given=list(_given(assignment)),
        pseudonym=key_for(assignment, public=False).pseudonym if tables.pseudonyms else None,
        columns=tables.columns,
        title=tables.title,
    )


def _paths(
    assignment: Assignment,
    folder: ResultFolder,
    results: Sequence[SubmissionResult],
    area: tuple[float, float],
) -> dict[str, dict[str, Floats]]:
    """Return the best paths by test and student, of the tests on the same floor."""
    of_students = {result.student: folder.paths(result.student) for result in results}
    return {
        test.name: {
            student: paths[test.name]
            for student, paths in of_students.items()
            if test.name in paths
        }
        for test in assignment.tests
        if test.task.scenario.area == area
    }


def _programs(assignment: Assignment, handed: Iterable[Handed]) -> Iterator[tuple[str, Program]]:
    for one in handed:
        try:
            files = read_submission(one.path, assignment._rules())
        except SubmissionError:
            continue
        yield one.student, program_of(files.sources)


def _given(assignment: Assignment) -> Iterator[Program]:
    """Yield what all have got."""
    yield program_of(assignment.files_of_all)
    for test in assignment.tests:
        yield program_of({f"{MODULE}.py": module_source(test.task)})
    start = assignment.folder / START
    if start.is_dir():
        yield program_of({file.name: file.read_bytes() for file in sorted(start.glob("*.py"))})
