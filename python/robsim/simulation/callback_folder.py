"""Writing and loading a folder of callback files, with checks of names and signatures."""

from __future__ import annotations

import ast
import difflib
import os
import re
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from robsim.base.files import as_path, copy_files
from robsim.base.spelling import closest
from robsim.base.text import one_line, quoted
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.errors import note_failed_file
from robsim.simulation.folder_modules import FolderModules, reserved_names
from robsim.simulation.slots import SLOTS

_CUTOFF = 0.8  # a folder has files of the user's own, too


def misspelled(names: Iterable[str]) -> dict[str, str]:
    """Return the names that resemble a slot name, with that slot."""
    names = list(names)
    slots = {other: name for name, slot in SLOTS.items() for other in (*slot.other_names, name)}
    suggestions = {}
    for name in names:
        slot = slots.get(closest(name, slots, cutoff=_CUTOFF) or "", name)
        # control_old.py beside control.py is a backup copy.
        is_copy = slot in names and re.match(rf"{slot}[\W\d_]", name.lower())
        if slot != name and not is_copy:
            suggestions[name] = slot
    return suggestions


_SAVING = 0.05  # s that an editor may need to write a file
_COARSEST_CLOCK = 2.0  # s between two times that a file can have, on any file system
Callbacks = dict[str, Callable[..., Any] | bool]


def new_folder(folder: str | PathLike[str]) -> list[Path]:
    """Write the default callbacks as templates to a folder, created if needed; return the files.

    If one of the files exists, it writes nothing (FileExistsError), nor if `folder` is a file
    (NotADirectoryError).
    """
    return copy_files([slot.template for slot in SLOTS.values()], folder)


class CallbackFolder:
    """A folder with a file for each callback, named after its slot, such as ``control.py``.

    A file defines a function of that name; ``ENABLED = False`` switches it off. Files for slots
    other than `slots` are not executed. Other files are helper modules, which the callbacks import
    by name; `given` modules by name, without ``.py``, replace them.
    """

    def __init__(
        self,
        folder: str | PathLike[str],
        slots: Sequence[str] = tuple(SLOTS),
        given: Mapping[str, bytes] = MappingProxyType({}),
    ) -> None:
        self._slots = slots
        self._given = given
        self.path = as_path(folder, "folder")
        self._absolute = self.path.absolute()  # valid after a change of directory
        self._modules = FolderModules(self.path, self._absolute, {})
        self._unchanged: list[tuple[str, int, int, int]] | None = None
        self._failed: dict[str, bytes] | None = None  # the sources of a load that has failed

    def load(self) -> Callbacks:
        """Read, compile and execute the files; if one fails, the previously loaded modules stay.

        Return the callback of each slot with a file; False = off, True = the default stage. An
        error of a file, also SyntaxError, gets a note with its name. A missing folder raises
        FileNotFoundError or NotADirectoryError; missing callbacks raise ValueError or TypeError. A
        name like a misspelled slot gives a UserWarning.
        """
        self._failed = sources = self._read()
        imported = imported_names(sources)
        for name in taken_names(sources, imported):
            raise ValueError(f"{self.path / name}.py {TAKEN}")
        for name, slot in misspelled(sources).items():
            if name not in imported:
                message = f"{self.path / name}.py is no callback: did you mean {slot}.py?"
                warnings.warn_explicit(message, UserWarning, str(self._absolute / f"{name}.py"), 0)
        modules = FolderModules(self.path, self._absolute, sources)
        callbacks = self._executed(modules)
        self._modules, self._unchanged, self._failed = modules, None, None
        return callbacks

    def load_saved(self) -> Callbacks:
        """Load; an error counts only for stable files, not for files during saving."""
        while True:
            sources = self._read()
            try:
                return self.load()
            except Exception:
                time.sleep(_SAVING)
                if self._read() == sources:
                    raise

    def anew(self) -> tuple[CallbackFolder, Callbacks]:
        """Return another folder of the same sources, and its callbacks, which share no modules."""
        return CallbackFolder.of_sources(
            self.path, self._absolute, self._modules.sources, self._slots
        )

    @classmethod
    def of_sources(
        cls,
        path: Path,
        absolute: Path,
        sources: Mapping[str, bytes],
        slots: Sequence[str],
        builtins: dict[str, Any] | None = None,
    ) -> tuple[CallbackFolder, Callbacks]:
        """Return a folder of already read files (`FolderModules`), and its callbacks."""
        other = cls(path, slots)
        other._absolute = absolute
        other._modules = FolderModules(path, absolute, sources, builtins)
        return other, other._executed(other._modules)

    @property
    def sources(self) -> Mapping[str, bytes]:
        """The last loaded files, by name without ``.py``."""
        return self._modules.sources

    def _executed(self, modules: FolderModules) -> Callbacks:
        with modules.importable():
            return {
                slot: self._loaded(modules, slot) for slot in self._slots if slot in modules.sources
            }

    def _loaded(self, modules: FolderModules, slot: str) -> Callable[..., Any] | bool:
        try:
            return callback_of_module(modules.execute(slot), slot, self.path / f"{slot}.py")
        except BaseException as error:
            note_failed_file(error, slot, str(self._absolute / f"{slot}.py"))
            raise

    @property
    def helpers(self) -> set[str]:
        """Names, without ``.py``, of the helper modules at the last load."""
        return set(self._modules.helpers)

    @property
    def files(self) -> set[str]:
        """Names, without ``.py``, of the Python files of the folder; raises as `changed`."""
        return set(self._read())

    @property
    def changed(self) -> set[str]:
        """Names, without ``.py``, of the files changed since they were loaded; raises as `load`."""
        state = self._state()
        if state is not None and state == self._unchanged:
            return set()
        now, then = self._read(), self._modules.sources
        changed = {name for name in now.keys() | then.keys() if now.get(name) != then.get(name)}
        self._unchanged = None if changed else state
        return changed

    @property
    def is_new(self) -> bool:
        """Whether the files differ from the last load, even a failed one; raises as `load`."""
        return self._read() != (self._failed or self._modules.sources)

    def _state(self) -> list[tuple[str, int, int, int]] | None:
        """Return a state that is equal if no file has changed, at a tenth of the cost of reading.

        The result may be None, because a file can change twice within the same time stamp.
        """
        newest = (time.time() - _COARSEST_CLOCK) * 1e9
        try:
            with os.scandir(self._absolute) as entries:
                files = [(e.name, e.stat()) for e in entries if e.name.endswith(".py")]
        except OSError:
            return None  # reading raises the error
        if any(file.st_mtime_ns > newest for _, file in files):
            return None
        return [(name, file.st_mtime_ns, file.st_size, file.st_ino) for name, file in files]

    @contextmanager
    def importable(self) -> Iterator[None]:
        """Let the callbacks import the helper modules inside the context.

        Other modules of the same names are restored afterwards. Other threads wait at the entry.
        """
        with self._modules.importable():
            yield

    def _read(self) -> dict[str, bytes]:
        """Return the content of the Python files by name, without ``.py``."""
        if not self._absolute.exists():
            raise FileNotFoundError(
                f"no folder {one_line(self.path)}: robsim new {one_line(self.path)} creates it"
            )
        if not self._absolute.is_dir():
            raise NotADirectoryError(f"{one_line(self.path)} is a file, not a folder of callbacks")
        # Editors keep temporary files with a leading dot.
        files = [file for file in self._absolute.glob("*.py") if not file.name.startswith(".")]
        sources = {file.stem: file.read_bytes() for file in sorted(files) if file.is_file()}
        if not sources.keys() & set(self._slots):
            hints = [
                f"; should {name}.py be {slot}.py?" for name, slot in misspelled(sources).items()
            ]
            remedy = f"robsim new {one_line(self.path)} writes them"
            if len(self._slots) < len(SLOTS):
                remedy = f"none for {', '.join(self._slots)}"
            raise ValueError(
                f"{one_line(self.path)} has no callback files: {remedy}" + "".join(hints)
            )
        return {**sources, **self._given}

    def __repr__(self) -> str:
        return f"<CallbackFolder: {one_line(self.path)}>"


def callback_of_module(module: ModuleType, slot: str, file: Path) -> Callable[..., Any] | bool:
    """Return a module's callback for a slot; a TypeError or ValueError has the file."""
    enabled = getattr(module, "ENABLED", True)
    if not isinstance(enabled, bool):
        raise TypeError(f"{one_line(file)}: ENABLED must be True or False, got {quoted(enabled)}")
    if not enabled:
        return False
    wanted = f"{slot}({SLOTS[slot].argument})"
    if not hasattr(module, slot):
        raise ValueError(
            f"{one_line(file)} must define {wanted}; it defines: {_definitions(module, slot)}"
        )
    callback = getattr(module, slot)
    if isinstance(callback, bool) and SLOTS[slot].is_switch:
        return callback
    if not callable(callback):
        raise TypeError(
            f"{one_line(file)}: {slot} must be a function {wanted}, got {quoted(callback)}"
        )
    try:
        check_callback(slot, callback)
    except TypeError as error:
        raise TypeError(f"{one_line(file)}: {error}") from None
    return callback  # type: ignore[no-any-return]


def _definitions(module: ModuleType, slot: str) -> str:
    """Return the callables that a file itself defines, by similarity to the name of the slot."""
    names = [
        name
        for name, value in vars(module).items()
        if callable(value) and getattr(value, "__module__", None) == module.__name__
    ]
    return ", ".join(sorted(names, key=lambda name: -_similarity(name, slot))) or "no function"


def _similarity(name: str, slot: str) -> float:
    return difflib.SequenceMatcher(None, name.lower(), slot).ratio()


#: The error of `taken_names`.
TAKEN = "has the name of a module of Python or robsim: rename it"


def taken_names(names: Iterable[str], imported: set[str]) -> list[str]:
    """Return the names of imported files that hide modules of Python or robsim."""
    return sorted(reserved_names(names) & imported)


def imported_names(sources: Mapping[str, bytes]) -> set[str]:
    """Return the top-level names of all modules that the files import."""
    names: set[str] = set()
    for name, source in sources.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # compiling the file later warns again
            try:
                tree = ast.parse(source)
            except (SyntaxError, ValueError, RecursionError, MemoryError):
                continue
        imported: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level < 2 and node.module:
                imported.add(node.module.partition(".")[0])
        names |= imported - {name}
    return names
