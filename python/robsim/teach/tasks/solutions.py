"""Solutions of tasks, right and wrong; robsim's own are a right one and changes of it.

A file of ``assets/solutions`` has the solutions of a task, in TOML::

    [base]                   # the files of a right solution by name
    "robot.py" = "park"      # a file that the base of another task has.
    [right.NAME]             # another one: the base with these changes, in turn.
    says = "..."             # the first line of its first file
    "old" = "new"            # instead of a text, in all files of the base that have it.
    "first ... last" = "new" # instead of all from the first words to the last
    "control.py" = "..."     # another file

A solution with a file for each slot has no other files of the base. The wheel has no such files,
but ``solutions.bin``, in which students do not find a solution by accident.
"""

from __future__ import annotations

import json
import re
import tomllib
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robsim.base.checks import check_bool
from robsim.base.files import as_folder
from robsim.base.text import one_line, quoted
from robsim.simulation.callback_folder import misspelled
from robsim.simulation.slots import SLOTS, checked_slots
from robsim.teach.submissions.at_home import callback_files, is_notebook, read_notebook
from robsim.teach.submissions.files import SubmissionFiles

if TYPE_CHECKING:
    from robsim.teach.tasks.definition import Task
#: The right solution that scores are relative to, and the wrong one that gets no points.
REFERENCE, NAIVE = "reference", "naive"
#: The module with the values of a task for its solutions.
MODULE = "task"
_START = Path(__file__).parent / "start"


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Code for the slots of a task.

    Attributes
    ----------
    name : str
        Its name; scores are relative to ``"reference"`` and ``"naive"``.
    is_right : bool
        Whether full points are expected.
    folder : Path, optional
        Its source folder; None = part of robsim.
    files : mapping of str to bytes
        The Python files by name without ``.py``, with their content at that time.
    slots : tuple of str
        The slots that it may fill.
    notebook : SubmissionFiles, optional
        The notebook that the files run; None = no notebook.

    Examples
    --------
    >>> [one.name for one in robsim.teach.ParkTask().solutions if one.is_right]
    ['reference', 'straight']
    """

    name: str
    is_right: bool
    folder: Path | None
    files: Mapping[str, bytes] = field(repr=False)
    slots: tuple[str, ...]
    notebook: SubmissionFiles | None = field(default=None, repr=False)

    @classmethod
    def load(cls, folder: str | PathLike[str], slots: Iterable[str], *, is_right: bool) -> Solution:
        """Read the files of a folder, a single file, or a notebook without running any code.

        Parameters
        ----------
        folder : path
            The folder, the file of a slot, a notebook, or a folder with a notebook instead of files
            of slots.
        slots : sequence of str
            The slots that it may fill.
        is_right : bool
            Whether full points are expected.

        Raises
        ------
        OSError
            If the folder is missing or unreadable.
        TypeError, ValueError
            If an argument is wrong, or the folder has no file for a slot.
        """
        path = as_folder(folder)
        check_bool("is_right", is_right)
        slots = checked_slots(slots, tuple(SLOTS))
        is_file = path.is_file()
        how: dict[str, Any] = {"name": path.name, "is_right": is_right, "slots": slots}
        home = path.parent if is_file else path
        if is_notebook(path, slots):
            notebook = read_notebook(path, slots)
            return cls(**how, folder=home, files=callback_files(notebook), notebook=notebook)
        found = [path] if is_file else sorted(path.iterdir())
        files = {
            file.stem: file.read_bytes()
            for file in found
            if file.suffix == ".py" and file.is_file() and file.stem != MODULE
        }
        if not files.keys() & set(slots):
            raise ValueError(_what_is_missing(path, files, slots))
        return cls(**how, folder=home, files=files)

    def __repr__(self) -> str:
        kind = "right" if self.is_right else "wrong"
        return f"<Solution {quoted(self.name)}, {kind}: {', '.join(sorted(self.files))}>"


def _what_is_missing(path: Path, files: Iterable[str], slots: tuple[str, ...]) -> str:
    wanted = " or ".join(f"{slot}.py" for slot in slots)
    meant = [f"; is {name}.py meant to be {slot}.py?" for name, slot in misspelled(files).items()]
    if path.is_file():
        return f"{one_line(path)} must be {wanted}" + "".join(meant)
    return f"{one_line(path)} has no solution: it must have {wanted}" + "".join(meant)


def module_source(task: Task) -> bytes:
    lines = [f'"""The values of the task: {task.title}."""', ""]
    lines += [f"{name} = {value!r}" for name, value in task.values.items()]
    return ("\n".join(lines) + "\n").encode()


def starting_files(task: Task) -> dict[str, bytes]:
    """Return the files of slots, without the module `task`."""
    return {file.name: file.read_bytes() for file in (_START / task.name).glob("*.py")}


def solutions_in(folder: str | PathLike[str], slots: tuple[str, ...]) -> tuple[Solution, ...]:
    """Return the solutions of a folder: those in ``right``, the reference first, and ``wrong``.

    Raise OSError, or ValueError without a reference or without a slot.
    """
    found = tuple(with_shared(_found(as_folder(folder), slots)))
    if not any(one.is_right and one.name == REFERENCE for one in found):
        raise ValueError(f"{one_line(folder)} must have a solution right/{REFERENCE}")
    return found


def _found(folder: Path, slots: tuple[str, ...]) -> Iterator[Solution]:
    for kind, first in (("right", REFERENCE), ("wrong", NAIVE)):
        named = (one for one in (folder / kind).glob("*") if not one.name.startswith((".", "__")))
        places = [one for one in named if one.is_dir()]
        for place in sorted(places, key=lambda one: (one.name != first, one.name)):
            yield Solution.load(place, slots, is_right=kind == "right")


def with_shared(solutions: Iterable[Solution]) -> Iterator[Solution]:
    """Yield solutions with the helpers of the reference, the first, so that none repeats them."""
    shared: dict[str, bytes] = {}
    for one in solutions:
        if one.is_right and one.name == REFERENCE:
            shared = helpers(one)
        yield replace(one, files={**shared, **one.files})


def helpers(solution: Solution) -> dict[str, bytes]:
    return {name: file for name, file in solution.files.items() if name not in SLOTS}


PACKED = Path(__file__).with_name("solutions.bin")
_SAYS = "says"


def pack(sources: Mapping[str, str]) -> bytes:
    """Return the solutions of tasks, as TOML by the name of the task, in one file."""
    return zlib.compress(json.dumps(sources).encode(), level=9)


def unpack(packed: bytes) -> dict[str, str]:
    sources: dict[str, str] = json.loads(zlib.decompress(packed))
    return sources


@cache
def shipped_solutions(task: str, slots: tuple[str, ...]) -> tuple[Solution, ...]:
    """Return the solutions of a kind of task that ship with robsim, in the order of their file."""
    tasks = {name: tomllib.loads(text) for name, text in unpack(PACKED.read_bytes()).items()}
    base = tasks[task]["base"]
    for name, text in base.items():
        if text in tasks:
            base[name] = tasks[text]["base"][name]
    return tuple(with_shared(_solutions(tasks[task], slots)))


def _solutions(tables: Mapping[str, Any], slots: tuple[str, ...]) -> Iterator[Solution]:
    for kind in ("right", "wrong"):
        for name, changes in tables[kind].items():
            try:
                files = _changed(tables["base"], changes, slots)
            except ValueError as error:
                raise ValueError(f"{kind}.{name}: {error}") from None
            yield Solution(
                name=name,
                is_right=kind == "right",
                folder=None,
                files={file.removesuffix(".py"): text.encode() for file, text in files.items()},
                slots=slots,
            )


def _changed(
    base: Mapping[str, str], changes: Mapping[str, str], slots: tuple[str, ...]
) -> dict[str, str]:
    own = {key: text for key, text in changes.items() if key.endswith(".py")}
    is_whole = all(f"{slot}.py" in own for slot in slots)
    files = {} if is_whole else {name: text for name, text in base.items() if name not in own}
    for key, new in changes.items():
        if key in own:
            continue
        old = next(iter(base.values())).split('"""')[1] if key == _SAYS else key
        changed = {name: _replaced(text, old, new) for name, text in files.items()}
        if changed == files:
            raise ValueError(f"no file has the text {old!r}")
        files = changed
    return files | own


def _replaced(text: str, old: str, new: str) -> str:
    part = ".*?".join(map(re.escape, old.split(" ... ")))
    return re.sub(part, lambda _: new, text, flags=re.DOTALL)
