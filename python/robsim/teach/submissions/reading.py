"""Reading a submission (a folder, a Python file, a zip, a notebook) without running its code."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path, PurePosixPath

from robsim.base.files import as_path
from robsim.base.text import listed, one_line
from robsim.simulation.callback_folder import TAKEN, imported_names, misspelled, taken_names
from robsim.simulation.folder_modules import reserved_names
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.archive import most_of_archive, read_archive, read_from_class
from robsim.teach.submissions.files import FILE, FOLDER, NOTEBOOK, SubmissionFiles
from robsim.teach.submissions.folder import (
    FORMS,
    Intake,
    is_read,
    kind_of,
    lone_zip,
    read_file,
    read_folder,
    size_text,
)
from robsim.teach.submissions.names import refusal, refusal_in
from robsim.teach.submissions.notebook.cells import reduced
from robsim.teach.submissions.notebook.choosing import chosen
from robsim.teach.submissions.python_text import (
    check_source,
    decoded,
    imported_words,
    slots_of_module,
)
from robsim.teach.submissions.rules import Rules

_TAKEN = "hand in a folder, a Python file (.py), a notebook (.ipynb) or a zip of these"


def read_submission(
    path: str | PathLike[str], rules: Rules, given: Mapping[str, bytes] | None = None
) -> SubmissionFiles:
    """Return a submission without running it.

    The path is a folder with a file for each slot, such as ``control.py``, and helper modules; or a
    Python file or notebook that defines them; or a zip of these, or a folder with such a zip. Given
    files, by name, replace copies at the top of the submission.

    A SubmissionError has the remedy. A wrong path raises TypeError or ValueError.
    """
    return arranged(open_submission(path, rules), rules, given or {})


@dataclass(frozen=True)
class Contents:
    """The files of a submission by their paths in it, before the choice of those that count."""

    name: str  # the name of its folder or file
    files: dict[str, bytes]
    #: Whether a Python file or a notebook was submitted, not a folder or zip.
    is_one_file: bool = False
    #: A cache: the files that count, by rules and by copies of given files in the submission.
    found: dict[tuple[Rules, frozenset[str]], SubmissionFiles] = field(
        default_factory=dict, repr=False, compare=False
    )

    def written_to(self, folder: Path) -> Path:
        """Write the files into a new folder, and return the path of the submission in it."""
        top = folder if self.is_one_file else folder / re.sub(r"[^\w ()-]", "_", self.name)
        top.mkdir(parents=True)
        for path, content in self.files.items():
            (top / path).parent.mkdir(parents=True, exist_ok=True)
            (top / path).write_bytes(content)
        return top / next(iter(self.files)) if self.is_one_file else top


def open_submission(
    path: str | PathLike[str], rules: Rules, files: Sequence[tuple[str, str]] = ()
) -> Contents:
    """Return the files of a submission, within the limits of rules; raise as `read_submission`.

    With `files`, pairs of a place and its name in the submission, the path is a class: a folder or
    a zip. The place of a folder ends in "/".
    """
    place = Path(os.path.abspath(as_path(path)))
    return _of_class(place, files, rules) if files else _opened(place, rules)


def _of_class(path: Path, files: Sequence[tuple[str, str]], rules: Rules) -> Contents:
    first, name = files[0]
    is_one_file = len(files) == 1 and bool(name)
    whole = one_line(name if is_one_file else PurePosixPath(first).name)
    if is_one_file and not name.lower().endswith(FORMS):
        raise refusal(whole, f" cannot be graded: {_TAKEN}")
    intake = Intake(whole, rules)
    if not path.is_dir():
        intake = read_from_class(path, files, intake)
    else:
        for place, file in files:
            most = intake.most_of(file)
            content = _all_of(path / place, one_line(place), most) if is_read(file) else b""
            intake.add(file, content)
    is_one_file = is_one_file and not name.lower().endswith(FORMS[0])
    return Contents(intake.whole, intake.files, is_one_file)


def arranged(contents: Contents, rules: Rules, given: Mapping[str, bytes]) -> SubmissionFiles:
    """Return the files that count, read once for the same rules; raise as `read_submission`."""
    paths = [f"/{path}" for path in contents.files]
    copies = frozenset(name for name in given if any(path.endswith(f"/{name}") for path in paths))
    if (rules, copies) not in contents.found:
        if contents.is_one_file:
            (main,) = contents.files
            found = _of_one_file(contents.name, main, contents.files, rules)
        else:
            found = _arranged(contents.name, contents.files, rules, copies)
        contents.found[rules, copies] = found
    files = contents.found[rules, copies]
    changed = [
        name
        for path, content in contents.files.items()
        if (name := PurePosixPath(path).name) in given and content.split() != given[name].split()
    ]
    notes = [f"{name} comes with the assignment: changes to it do not count" for name in changed]
    return replace(files, sources={**files.sources, **given}, notes=(*files.notes, *notes))


def _opened(path: Path, rules: Rules) -> Contents:
    name = one_line(path.name)
    intake = Intake(name, rules)
    if kind_of(str(path), name) == stat.S_IFDIR:
        packed = lone_zip(str(path), Intake(name, rules))
        if packed is not None and kind_of(str(path / packed), one_line(packed)) == stat.S_IFREG:
            return _opened(path / packed, rules)
        read_folder(str(path), intake)
        return Contents(name, intake.files)
    suffix = path.suffix.lower()
    if suffix == ".zip":
        read_archive(_all_of(path, name, most_of_archive(rules)), intake)
        return Contents(name, intake.files)
    if suffix not in FORMS:
        raise refusal(name, f" cannot be graded: {_TAKEN}")
    file = f"{path.stem}{suffix}"
    intake.add(file, _all_of(path, name, intake.most_of(file)))
    if not intake.files:
        raise refusal(name, " is a hidden file: give it another name")
    return Contents(name, intake.files, is_one_file=True)


def _all_of(path: Path, name: str, most: int) -> bytes:
    content = read_file(str(path), name, most + 1)
    if len(content) > most:
        remedy = "clear its outputs" if path.suffix.lower() == ".ipynb" else "make it smaller"
        raise refusal(name, f" has more than {size_text(most)}: {remedy}")
    return content


def _arranged(
    name: str, files: dict[str, bytes], rules: Rules, given: Collection[str]
) -> SubmissionFiles:
    """Return the submission of a folder: by files of slots, or by the one file that has them."""
    files = {path: each for path, each in _below_the_top(files).items() if path not in given}
    top = [path for path in files if "/" not in path]
    python = [path for path in top if path.endswith(".py")]
    notebooks = [path for path in top if path.endswith(".ipynb")]
    if any(_slot_of(path, rules) in rules.names for path in python):
        return _of_folder(name, files, rules)
    mains = notebooks or python
    if len(mains) == 1 and _slot_of(mains[0], rules) is None:
        return _of_one_file(name, mains[0], files, rules)
    if len(mains) > 1 and notebooks:
        raise SubmissionError(
            f"{name} has {len(mains)} notebooks, {listed(mains)}: hand in only one notebook"
        )
    raise _nothing(name, files, rules)


def _below_the_top(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the files without the folder or folders that contain all of them."""
    while (
        files and len({path.partition("/")[0] for path in files}) == 1 and "/" in next(iter(files))
    ):
        files = {path.partition("/")[2]: content for path, content in files.items()}
    return files


def _slot_of(path: str, rules: Rules) -> str | None:
    stem = PurePosixPath(path).stem
    is_one = stem in SLOTS or stem in rules.functions
    return stem if is_one and path == f"{stem}.py" else None


def _nothing(name: str, files: dict[str, bytes], rules: Rules) -> SubmissionError:
    wanted = " or ".join(f"{name}.py" for name in rules.names)
    stems = {PurePosixPath(path).stem: path for path in files if path.endswith((".py", ".ipynb"))}
    hints = [
        f"; is {one_line(stems[stem])} meant to be {slot}.py?"
        for stem, slot in misspelled(stems).items()
        if slot in rules.slots
    ]
    found = f"it has {listed(sorted(files))}" if files else "it is empty"
    return SubmissionError(f"{name} has no {wanted}: {found}" + "".join(hints))


def _of_folder(name: str, files: dict[str, bytes], rules: Rules) -> SubmissionFiles:
    of_slots = {slot: path for path in files if (slot := _slot_of(path, rules))}
    slots = tuple(name for name in rules.names if name in of_slots)
    used = {of_slots[slot] for slot in slots} | _imported_files(files, rules)
    for path in sorted(used):
        check_source(files[path], one_line(path))
    _check_spelling(name, files, used, slots, rules)
    _check_helpers(name, files)
    notes = [
        f"{path} is not used: the assignment does not have this slot"
        for slot, path in of_slots.items()
        if slot not in rules.names
    ]
    notebooks = [path for path in files if path.endswith(".ipynb") and "/" not in path]
    notes += [f"{path} is not used, because {slots[0]}.py exists" for path in notebooks]
    return SubmissionFiles(name, FOLDER, "", files, slots, tuple(notes))


def _modules(files: dict[str, bytes]) -> dict[str, bytes]:
    return {path: c for path, c in files.items() if "/" not in path and path.endswith(".py")}


def _imported_files(files: dict[str, bytes], rules: Rules) -> set[str]:
    words = {path: imported_words(content) for path, content in _modules(files).items()}
    return {
        path
        for path in words
        if _slot_of(path, rules) is None
        and any(PurePosixPath(path).stem in words[other] for other in words if other != path)
    }


def _check_spelling(
    name: str, files: dict[str, bytes], used: set[str], slots: tuple[str, ...], rules: Rules
) -> None:
    """Refuse a file whose name resembles the name of an empty slot."""
    stems = [PurePosixPath(path).stem for path in _modules(files)]
    for stem, slot in misspelled(stems).items():
        if slot in rules.slots and slot not in slots and f"{stem}.py" not in used:
            said = f"matches no slot: rename it to {slot}.py, or remove it"
            raise refusal_in(name, f"{stem}.py", said)


def _check_helpers(name: str, files: dict[str, bytes]) -> None:
    """Refuse helper modules that Python would not find or would confuse."""
    sources = {PurePosixPath(path).stem: content for path, content in _modules(files).items()}
    if reserved_names(sources):  # of compiled files, or of files without an import
        for stem in taken_names(sources, imported_names(sources)):
            raise refusal_in(name, f"{stem}.py", TAKEN)
    words = set().union(*map(imported_words, sources.values()))
    folders = {path.partition("/")[0] for path in files if "/" in path and path.endswith(".py")}
    for folder in sorted(folders & words):
        said = "is a folder of modules, which cannot be imported: move its files to the others"
        raise refusal_in(name, folder, said)


def _of_one_file(name: str, main: str, files: dict[str, bytes], rules: Rules) -> SubmissionFiles:
    if main.endswith(".ipynb"):
        small = reduced(files[main], main, rules.file_size)
        notebook = chosen(small, main, rules.names)
        sources = {**files, main: small}
        return SubmissionFiles(name, NOTEBOOK, main, sources, notebook.slots, notebook.notes)
    slot = _slot_of(main, rules)
    if slot in rules.slots:
        return _of_folder(name, files, rules)
    if slot in SLOTS:
        raise _nothing(name, files, rules)
    check_source(files[main], one_line(main))
    slots = slots_of_module(decoded(files[main], main), main, rules.names)
    return SubmissionFiles(name, FILE, main, files, slots)
