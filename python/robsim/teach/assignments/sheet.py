"""The sheet of an assignment, and the comparison of its numbers with the tests."""

from __future__ import annotations

import re
from collections.abc import Iterator

from robsim.teach.assignments.assignment import Assignment
from robsim.teach.results import number
from robsim.teach.submissions.folder import size_text
from robsim.teach.submissions.notebook.choosing import COUNTS
from robsim.teach.tasks.definition import Task, table_of

SHEET = "sheet.md"


def sheet_for(assignment: Assignment) -> str:
    return "\n\n".join(_parts(assignment)) + "\n"


def told_task(assignment: Assignment) -> Task:
    """Return the task of the sheet: of the first public test, if any is public."""
    public = [test for test in assignment.tests if test.public]
    return (public or assignment.tests)[0].task


def _parts(assignment: Assignment) -> Iterator[str]:
    yield told_task(assignment).sheet.partition("\n## Try it\n")[0].strip()
    yield "## Points"
    yield "\n".join(["| test | points | | |", "| --- | --- | --- | --- |", *_rows(assignment)])
    yield (
        "Hidden tests are the same tasks in unknown worlds; each student has different worlds."
        if assignment.own_seeds
        else "Hidden tests are the same tasks in unknown worlds."
    )
    yield "## Try it, hand it in"
    yield (
        "Begin with the files in `start/`: copy them to a folder `mine/`. Hand in that "
        "folder, or a zip of it, a single Python file, or a notebook that defines "
        f"{' and '.join(f'`{slot}`' for slot in assignment.slots)}. Put your own modules next to "
        "these files, not in folders; also data files, which "
        '`open("data.csv")` finds.'
    )
    limits = assignment.limits
    yield (
        f"A file may have {size_text(limits.submission_file_size)}, all files together "
        f"{size_text(limits.submission_size)}. Reports (.pdf, .docx, .odt) may have any size."
    )
    yield COUNTS
    yield (
        "A call may take `call` s, the first call of a run `first_call` s: a run with a longer "
        "call has no points."
    )
    yield table_of({name: getattr(limits, name) for name in ("call", "first_call")})
    yield "```\nrobsim grade . mine --public\n```"
    yield (
        "runs the public tests exactly as in grading, and writes a page with "
        "pictures of your errors. `robsim check mine` looks for mistakes in your files."
    )


def _rows(assignment: Assignment) -> Iterator[str]:
    for test in assignment.tests:
        who = "public" if test.public else "hidden"
        yield f"| `{test.name}` | `{number(test.points)}` | {test.title} | {who} |"
    for file in assignment.files:
        yield (
            f"| others | see `pytest.mark.points` | tests in `{file.path.name}` | public |"
            if file.public
            else f"| others | others | tests in `{file.path.name}` | hidden |"
        )


#: A row of a table of numbers: a name and a value.
_ROW = re.compile(r"^[ \t]*\|[ \t]*`(\w+)`[ \t]*\|[ \t]*`([^`\n]*)`", re.MULTILINE)


def compare_sheet(assignment: Assignment) -> tuple[str, list[str]]:
    """Return the numbers of the sheet that differ from the tests, and the names without a row.

    The sheet has such numbers only in rows: ``| `steps` | `60` |``. Its text is for the teacher.
    """
    file = assignment.folder / SHEET
    text = file.read_text("utf-8", "replace") if file.is_file() else ""
    wrong, missing, rows = [], [], _ROW.findall(text)
    for name, expected in _ROW.findall(sheet_for(assignment)) if assignment.tests else []:
        told = [value for other, value in rows if other == name]
        if not told:
            missing.append(name)
        elif not any(_short(one) == _short(expected) for one in told):
            wrong.append(f"{name} is {told[0]}, must be {expected}")
    return "; ".join(wrong), missing


def _short(number: str) -> str:
    return re.sub(r"\s|\.0\b", "", number)  # 450.0 is 450
