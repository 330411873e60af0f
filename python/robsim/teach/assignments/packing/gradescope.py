"""`pack_gradescope`: the zip of an autograder for Gradescope."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from os import PathLike
from pathlib import Path

from robsim.base.files import as_path, write_whole
from robsim.base.text import one_line, quoted
from robsim.teach.assignments import limits_file
from robsim.teach.assignments.assignment import Assignment, check_is_assignment
from robsim.teach.assignments.assignment_file import FILE, GIVEN, KEY, SOLUTIONS
from robsim.teach.assignments.classes.plan import plan_of
from robsim.teach.assignments.packing.public_part import limits_alone
from robsim.teach.tasks.solutions import REFERENCE

_MADE = (1980, 1, 1, 0, 0, 0)  # the earliest time in a zip
_REGULAR = 0o100000


def write_zip(
    path: Path, files: Mapping[str, bytes], *, modes: Mapping[str, int] | None = None
) -> None:
    """Write files to a zip atomically; without its mode, every user may read a file."""
    import zipfile

    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _MADE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whose modes these are
            entry.external_attr = (_REGULAR | (modes or {}).get(name, 0o644)) << 16
            archive.writestr(entry, files[name])
    write_whole(path, content.getvalue())


#: The folder of the assignment, in the autograder's folder.
ASSIGNMENT = "assignment"
_FILES = Path(__file__).parents[1] / "templates/gradescope"
_MODES = {"run_autograder": 0o755, "setup.sh": 0o755, f"{ASSIGNMENT}/{KEY}": 0o600}


def pack_gradescope(
    assignment: Assignment, path: str | PathLike[str], *, install: str | PathLike[str] | None = None
) -> Path:
    """Write the autograder of an assignment for Gradescope, with the key and the hidden tests.

    Parameters
    ----------
    assignment : Assignment
        The assignment.
    path : path
        The zip; an old one is overwritten.
    install : path or str, optional
        The package to install there: a wheel, which becomes part of the zip, or a requirement for
        pip such as ``"robsim==1.2"``. Default: the installed version of robsim, from pip's usual
        source.

    Returns
    -------
    Path
        The zip.

    Raises
    ------
    AssignmentError
        If a test has no limits, or the key is missing.
    OSError
        If the zip cannot be written, or the wheel cannot be read.
    TypeError, ValueError
        If an argument is wrong.

    Notes
    -----
    After https://gradescope-autograders.readthedocs.io/en/latest/specs: ``setup.sh`` runs once, for
    the image; ``run_autograder`` runs for each submission in ``/autograder/submission``, and writes
    ``/autograder/results/results.json``.

    Examples
    --------
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> robsim.teach.pack_gradescope(assignment, "autograder.zip").name
    'autograder.zip'
    """
    check_is_assignment(assignment)
    file = as_path(path)
    if file.suffix != ".zip":
        raise ValueError(f"path must end in .zip, got {quoted(str(file))}")
    wheel, line = _installed(install)
    plan_of(assignment)  # raises for a missing part
    files = dict(_assignment_files(assignment))
    for name in ("setup.sh", "run_autograder"):
        files[name] = (_FILES / name).read_bytes()
    if wheel is not None:
        files[wheel.name] = wheel.read_bytes()
    files["requirements.txt"] = f"{line}\npytest\n".encode()
    write_zip(file, files, modes=_MODES)
    return file


def _assignment_files(assignment: Assignment) -> Iterator[tuple[str, bytes]]:
    folder = assignment.folder
    yield f"{ASSIGNMENT}/{limits_file.FILE}", limits_alone(assignment).encode()
    needed = [folder / FILE, folder / KEY]
    needed += sorted(folder.glob("*.py"))
    needed += [file.path for file in assignment.files]
    needed += sorted((folder / GIVEN).glob("*"))
    for test in assignment.tests:
        needed += sorted((folder / SOLUTIONS / test.task.name / "right" / REFERENCE).glob("*.py"))
    for file in dict.fromkeys(needed):
        if file.is_file():
            yield f"{ASSIGNMENT}/{file.relative_to(folder).as_posix()}", file.read_bytes()


def _installed(install: str | PathLike[str] | None) -> tuple[Path | None, str]:
    """Return the wheel for the zip, if any, and the line of requirements.txt."""
    if install is None:
        return None, f"robsim=={version('robsim')}"
    if isinstance(install, str) and not install.endswith(".whl"):
        return None, one_line(install)
    wheel = as_path(install, "install")
    return wheel, f"./{wheel.name}"
