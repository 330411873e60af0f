"""What students read: the sheet of the task, and what the assignment says of it."""

from __future__ import annotations

from collections.abc import Iterator

from robsim.teach.assignments.assignment import Assignment


def sheet_for(assignment: Assignment) -> str:
    return "\n\n".join(_parts(assignment)) + "\n"


def _parts(assignment: Assignment) -> Iterator[str]:
    test = assignment.tests[0]
    yield test.task.sheet.partition("\n## Try it\n")[0].strip()
    yield "## Points"
    yield "\n".join(["| test | points | |", "| --- | --- | --- |", *_rows(assignment)])
    yield (
        "Tests that are not public are the same tasks in worlds that nobody knows beforehand; each "
        "student has others."
        if assignment.own_seeds
        else "Tests that are not public are the same tasks in worlds that nobody knows beforehand."
    )
    yield "## Try it, hand it in"
    yield (
        "Begin with the files in `start/`: copy them to a folder `mine/`. What you hand in is that "
        "folder, or a zip of it, a single Python file, or a notebook that defines "
        f"{' and '.join(f'`{slot}`' for slot in assignment.slots)}. Modules of your own lie beside "
        "these files, not in folders of their own; so do files with data, which "
        '`open("data.csv")` finds.'
    )
    limits = assignment.limits
    yield (
        f"A call may take {limits.call:g} s, the first one of a run {limits.first_call:g} s: a run "
        "in which one takes longer has no points."
    )
    yield "```\nrobsim grade . mine --public\n```"
    yield (
        "runs the public tests as they will be run when it is graded, and writes a page with "
        "pictures of what went wrong. `robsim check mine` looks for mistakes in your files."
    )


def _rows(assignment: Assignment) -> Iterator[str]:
    for test in assignment.tests:
        who = "public" if test.public else "not public"
        yield f"| {test.title} | {test.points:g} | {who} |"
    for file in assignment.files:
        yield (
            f"| tests in `{file.path.name}` | those in its `pytest.mark.points` | public |"
            if file.public
            else f"| tests in `{file.path.name}` | others | not public |"
        )
