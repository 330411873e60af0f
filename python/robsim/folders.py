"""Callbacks from a folder."""

from __future__ import annotations

import ast
import difflib
import importlib.util
import inspect
import io
import linecache
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

from robsim.files import as_folder, copy_files

#: The slots and the argument that each callback gets.
ARGUMENTS = {
    "define_model": "",
    "init_parameter_estimator": "model",
    "adjust_background": "background",
    "evaluate_model": "world",
    "estimate_parameters": "step",
    "measure": "step",
    "estimate_state": "step",
    "control": "step",
}

_TEMPLATES = Path(__file__).with_name("templates")

# Slots that take True for robsim's own stage.
_SWITCHES = ("estimate_parameters", "measure")

# What the original program called them, and what else they may be looked for under.
_OTHER_NAMES = {
    "robotModelDef": "define_model",
    "myParameterEstimatorInit": "init_parameter_estimator",
    "background": "adjust_background",
    "robotModelEval": "evaluate_model",
    "myParameterEstimator": "estimate_parameters",
    "measurePosNOrientation": "measure",
    "measurement": "measure",
    "stateEstimator": "estimate_state",
    "robotController": "control",
}

# A helper of such a name would hide it from Python or from robsim.
_TAKEN = sys.stdlib_module_names | {
    "__main__", "robsim", "numpy", "PIL", "matplotlib", "cv2", "pandas", "rich", "tqdm", "typer"
}  # fmt: skip

# sys.modules belongs to the process: one folder at a time.
_LOCK = threading.RLock()

Callbacks = dict[str, Callable[..., Any] | bool]


def new_folder(folder: str | PathLike[str]) -> list[Path]:
    """Write the default callbacks to a folder, to be edited.

    Parameters
    ----------
    folder : path
        The folder; it is made if needed.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    FileExistsError
        If one of them is there already; then nothing is written.
    NotADirectoryError
        If `folder` is a file.
    """
    return copy_files([_TEMPLATES / f"{slot}.py" for slot in ARGUMENTS], folder)


class CallbackFolder:
    """A folder with a file for each callback, named after its slot, such as ``control.py``.

    A file defines a function of its own name. ``ENABLED = False`` in it switches it off. Other
    files of the folder are helpers, which the callbacks can import by name.

    Parameters
    ----------
    folder : path
        The folder.

    Raises
    ------
    TypeError
        If it is not a path.
    """

    def __init__(self, folder: str | PathLike[str]) -> None:
        self.path = as_folder(folder)
        self._place = self.path.absolute()  # wherever the program goes later
        self._modules = _Modules(self.path, self._place, {})

    def load(self) -> Callbacks:
        """Read, compile and execute the files; if one fails, what was loaded before stays.

        Returns
        -------
        dict of str to callable or bool
            The callbacks by slot. False = switched off, True = robsim's own stage. A slot without
            a file is not in it.

        Raises
        ------
        FileNotFoundError, NotADirectoryError
            If there is no such folder.
        ValueError, TypeError
            If it has no callback files, or one of them does not define its callback.
        Exception
            Whatever a file raises when it is executed, a SyntaxError among them, with a note that
            names the file.

        Warns
        -----
        UserWarning
            If the name of a file looks like that of a misspelt slot.
        """
        sources = self._read()
        imported = _imported_names(sources)
        for name in sorted(_taken_names(sources) & imported):
            raise ValueError(
                f"{self.path / name}.py has the name of a module that comes with Python or "
                "robsim: rename it"
            )
        for name, slot in _misspelt(sources).items():
            if name not in imported:
                message = f"{self.path / name}.py is no callback: did you mean {slot}.py?"
                warnings.warn_explicit(message, UserWarning, str(self._place / f"{name}.py"), 0)
        modules = _Modules(self.path, self._place, sources)
        with modules.importable():
            callbacks = {
                slot: _callback(modules.execute(slot), slot, self.path / f"{slot}.py")
                for slot in ARGUMENTS
                if slot in sources
            }
        self._modules = modules
        return callbacks

    @property
    def changed(self) -> set[str]:
        """Names, without ``.py``, of the files that are not what they were when they were loaded.

        Raises
        ------
        FileNotFoundError, NotADirectoryError, ValueError
            As `load`, if the folder or all its callbacks are gone.
        """
        now, then = self._read(), self._modules.sources
        return {name for name in now.keys() | then.keys() if now.get(name) != then.get(name)}

    @contextmanager
    def importable(self) -> Iterator[None]:
        """Let the callbacks import the helpers, for as long as the context lasts.

        Whatever other modules have the same names is put back afterwards. Other threads wait for
        their turn.
        """
        with self._modules.importable():
            yield

    def _read(self) -> dict[str, bytes]:
        """Return the content of the Python files by their names without ``.py``."""
        if not self._place.exists():
            raise FileNotFoundError(f"no folder {self.path}: robsim new {self.path} makes one")
        if not self._place.is_dir():
            raise NotADirectoryError(f"{self.path} is a file, not a folder of callbacks")
        # Editors keep files of their own with a dot in front.
        files = [file for file in self._place.glob("*.py") if not file.name.startswith(".")]
        sources = {file.stem: file.read_bytes() for file in sorted(files) if file.is_file()}
        if not sources.keys() & ARGUMENTS.keys():
            hints = [
                f"; did you mean {slot}.py by {name}.py?"
                for name, slot in _misspelt(sources).items()
            ]
            raise ValueError(
                f"{self.path} has no callback files: robsim new {self.path} writes them"
                + "".join(hints)
            )
        return sources

    def __repr__(self) -> str:
        return f"<CallbackFolder: {self.path}>"


class _Modules(MetaPathFinder, Loader):
    """The files of a folder as they were read, as modules: callbacks and their helpers.

    It is a finder and a loader of the import system. Nothing is written, no ``__pycache__``: its
    files are checked by whole seconds, and an edit within the second would go unseen.
    """

    def __init__(self, folder: Path, place: Path, sources: Mapping[str, bytes]) -> None:
        self.sources = sources
        self._folder = folder  # as the user calls it
        self._place = place
        self._helpers = sources.keys() - ARGUMENTS.keys() - _taken_names(sources)
        self._loaded: dict[str, ModuleType] = {}

    @contextmanager
    def importable(self) -> Iterator[None]:
        names = {*self._helpers, *map(_module_name, ARGUMENTS)}
        with _LOCK:
            others = {name: sys.modules.pop(name) for name in names & sys.modules.keys()}
            try:
                sys.modules.update(self._loaded)
                sys.meta_path.insert(0, self)
                yield
            finally:
                if self in sys.meta_path:
                    sys.meta_path.remove(self)
                for name in names & sys.modules.keys():
                    self._loaded[name] = sys.modules.pop(name)
                sys.modules.update(others)

    def execute(self, slot: str) -> ModuleType:
        """Return the module of a callback's file. Only while the folder is importable."""
        module = ModuleType(_module_name(slot))
        module.__file__ = str(self._place / f"{slot}.py")
        module.__package__ = ""
        # Dataclasses, for one, look for their module there.
        sys.modules[module.__name__] = module
        self.exec_module(module)
        return module

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name in self._helpers:
            file = self._place / f"{name}.py"
            return importlib.util.spec_from_file_location(name, file, loader=self)
        if name in ARGUMENTS and name in self.sources:
            return self._found_elsewhere(name)
        return None

    def _found_elsewhere(self, slot: str) -> ModuleSpec:
        """Return the package with a slot's name: python-control, say, is imported as control."""
        here = self._place.resolve()
        spec = PathFinder.find_spec(slot, [p for p in sys.path if Path(p).resolve() != here])
        if spec is None:
            raise ModuleNotFoundError(
                f"{self._folder / slot}.py is a callback, which others cannot import: put what "
                "several files need into one of another name",
                name=slot,
            )
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        stem = module.__name__.rpartition(".")[2]
        file = str(self._place / f"{stem}.py")
        try:
            code = _compiled(self.sources[stem], file)
            exec(code, module.__dict__)
        except BaseException as error:
            error.add_note(f"while loading {self._folder / stem}.py")
            raise


def _module_name(slot: str) -> str:
    return f"robsim_callbacks.{slot}"


def _compiled(source: bytes, file: str) -> Any:
    text = _decoded(source, file)
    code = compile(source, file, "exec", dont_inherit=True)
    # A traceback shows the lines that were compiled, even if the file is another by then.
    linecache.cache[file] = (len(source), None, list(io.StringIO(text)), file)
    return code


def _decoded(source: bytes, file: str) -> str:
    problem, place = "it has null bytes", source.find(b"\0")
    if place < 0:
        try:
            return importlib.util.decode_source(source)
        except (SyntaxError, UnicodeDecodeError) as error:
            problem, place = str(error), getattr(error, "start", 0)
    line = source.count(b"\n", 0, place) + 1
    raise SyntaxError(f"the file is no text in UTF-8: {problem}", (file, line, None, None))


def _callback(module: ModuleType, slot: str, file: Path) -> Callable[..., Any] | bool:
    """Return what a file defines for its slot, after a look at it."""
    enabled = getattr(module, "ENABLED", True)
    if not isinstance(enabled, bool):
        raise TypeError(f"{file}: ENABLED must be True or False, got {enabled!r}")
    if not enabled:
        return False
    wanted = f"{slot}({ARGUMENTS[slot]})"
    if not hasattr(module, slot):
        raise ValueError(f"{file} must define {wanted}; it defines: {_definitions(module, slot)}")
    callback = getattr(module, slot)
    if isinstance(callback, bool) and slot in _SWITCHES:
        return callback
    if not callable(callback):
        raise TypeError(f"{file}: {slot} must be a function {wanted}, got {callback!r}")
    signature = _signature(callback)
    arguments = [None] if ARGUMENTS[slot] else []
    if signature and not _takes(signature, arguments):
        count = "one argument" if arguments else "no argument"
        raise TypeError(f"{file}: {wanted} must take {count}, got {slot}{signature}")
    return callback  # type: ignore[no-any-return]


def _definitions(module: ModuleType, slot: str) -> str:
    """Return the names that a file defines itself, the one most like the slot's first."""
    names = [
        name
        for name, value in vars(module).items()
        if callable(value) and getattr(value, "__module__", None) == module.__name__
    ]
    return ", ".join(sorted(names, key=lambda name: -_likeness(name, slot))) or "no function"


def _likeness(name: str, slot: str) -> float:
    return difflib.SequenceMatcher(None, name.lower(), slot).ratio()


def _signature(callback: Callable[..., Any]) -> inspect.Signature | None:
    try:
        return inspect.signature(callback)
    except (TypeError, ValueError):  # of the core's own objects
        return None


def _takes(signature: inspect.Signature, arguments: list[None]) -> bool:
    try:
        signature.bind(*arguments)
    except TypeError:
        return False
    return True


def _taken_names(names: Iterable[str]) -> set[str]:
    return set(names) & _TAKEN


def _misspelt(names: Iterable[str]) -> dict[str, str]:
    """Return the names that look like those of slots, and the slots meant."""
    names = list(names)
    known = {_plain(name): slot for name, slot in _OTHER_NAMES.items()}
    known |= {_plain(slot): slot for slot in ARGUMENTS}
    meant = {}
    for name in names:
        close = difflib.get_close_matches(_plain(name), known, 1, cutoff=0.8)
        slot = known[close[0]] if close else name
        # control_old.py beside control.py is a copy that somebody keeps.
        is_copy = slot in names and re.match(rf"{slot}[\W\d_]", name.lower())
        if slot != name and not is_copy:
            meant[name] = slot
    return meant


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())


def _imported_names(sources: Mapping[str, bytes]) -> set[str]:
    """Return the modules that the files import from one another, or from elsewhere."""
    names: set[str] = set()
    for name, source in sources.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # compiling the file for good gives them once more
            try:
                tree = ast.parse(source)
            except (SyntaxError, ValueError, RecursionError, MemoryError):
                continue
        imported: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
                imported.add(node.module.partition(".")[0])
        names |= imported - {name}
    return names
