"""The command ``robsim assignment pack``: what students get, and an autograder for Gradescope."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from robsim.cli import errors
from robsim.cli.assignment.options import Folder, report_errors
from robsim.cli.option import option

EXAMPLE = "Example: robsim assignment pack hw1 --students hw1-students.zip"
HELP = (
    "Pack an assignment: for students, for Gradescope.\n\n"
    "Students get the sheet, files to begin with, and the public tests with what the reference "
    "came to in them: no key, no hidden test, no solution. The autograder has all that grading "
    "needs, the key as well: give it to nobody but Gradescope."
)


def pack(
    folder: Folder,
    students: Annotated[
        Path | None,
        option("--students", "ZIP|FOLDER", "Write what students get: a zip, or a folder."),
    ] = None,
    gradescope: Annotated[
        Path | None, option("--gradescope", "ZIP", "Write an autograder for Gradescope.")
    ] = None,
    install: Annotated[
        str | None,
        option(
            "--install",
            "WHEEL|NAME",
            "With --gradescope: what is installed there, a wheel of robsim, or what pip "
            "takes, such as robsim==1.2. Default: this version, from where pip finds it.",
        ),
    ] = None,
) -> None:
    """Pack an assignment: for students, for Gradescope."""
    from robsim.teach.assignments.assignment import Assignment
    from robsim.teach.assignments.packing.gradescope import pack_gradescope
    from robsim.teach.assignments.packing.students import pack_students

    with report_errors():
        if students is None and gradescope is None:
            raise ValueError("what is to be packed? --students ZIP, --gradescope ZIP, or both")
        if install is not None and gradescope is None:
            raise ValueError("--install is for an autograder: give --gradescope ZIP, too")
        assignment = Assignment.load(folder)
        if students is not None:
            pack_students(assignment, students)
            errors.say(f"for students: {students}")
        if gradescope is not None:
            pack_gradescope(assignment, gradescope, install=install)
            errors.say(f"for Gradescope, with the key in it: {gradescope}")
