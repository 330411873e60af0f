"""The files of a folder as modules."""

from __future__ import annotations

import importlib.util
import io
import linecache
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from robsim.simulation._slots import ARGUMENTS

# A helper of such a name would hide it from Python or from robsim.
_TAKEN = sys.stdlib_module_names | {
    "__main__", "robsim", "numpy", "PIL", "matplotlib", "cv2", "pandas", "rich", "tqdm", "typer"
}  # fmt: skip

# sys.modules belongs to the process: one folder at a time.
_LOCK = threading.RLock()


class FolderModules(MetaPathFinder, Loader):
    """The files of a folder as they were read, as modules: callbacks and their helpers.

    It is a finder and a loader of the import system. Nothing is written, no ``__pycache__``: its
    files are checked by whole seconds, and an edit within the second would go unseen.
    """

    def __init__(self, folder: Path, place: Path, sources: Mapping[str, bytes]) -> None:
        self.sources = sources
        self._folder = folder  # as the user calls it
        self._place = place
        self._helpers = sources.keys() - ARGUMENTS.keys() - taken_names(sources)
        self._loaded: dict[str, ModuleType] = {}

    @contextmanager
    def importable(self) -> Iterator[None]:
        """Let them be imported for as long as the context lasts; then put back what was there."""
        names = {*self._helpers, *map(module_name, ARGUMENTS)}
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
        module = ModuleType(module_name(slot))
        module.__file__ = str(self._place / f"{slot}.py")
        module.__package__ = ""
        # Dataclasses, for one, look for their module there.
        sys.modules[module.__name__] = module
        self.exec_module(module)
        return module

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a helper; Python asks."""
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
        """Leave it to Python to make the module."""
        return

    def exec_module(self, module: ModuleType) -> None:
        """Compile and execute the file of a module."""
        stem = module.__name__.rpartition(".")[2]
        file = str(self._place / f"{stem}.py")
        try:
            code = _compiled(self.sources[stem], file)
            exec(code, module.__dict__)
        except BaseException as error:
            error.add_note(f"while loading {self._folder / stem}.py")
            raise


def module_name(slot: str) -> str:
    """Return the name that the module of a slot's file has."""
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


def taken_names(names: Iterable[str]) -> set[str]:
    """Return those of the names that modules of Python or of robsim have."""
    return set(names) & _TAKEN
