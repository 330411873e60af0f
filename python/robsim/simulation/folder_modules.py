"""Import hook that makes the files of a callback folder importable without cached bytecode."""

from __future__ import annotations

import ast
import importlib.util
import io
import linecache
import re
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from robsim.simulation.slots import SLOTS

# A helper module of such a name would shadow it for Python or for robsim.
_RESERVED = sys.stdlib_module_names | {
    *("__main__", "robsim", "numpy", "PIL", "matplotlib", "cv2", "av"),
    *("pandas", "rich", "tqdm", "typer"),
}
_PACKAGE = "robsim_callbacks."
_RELATIVE = re.compile(rb"\bfrom\s*\.")
# sys.modules is shared by the process: one folder at a time.
_LOCK = threading.RLock()


class FolderModules(MetaPathFinder, Loader):
    """The files of a folder, as read, as modules: callbacks and helper modules.

    A finder and loader of the import system. It writes no ``__pycache__``, because cached bytecode
    has time stamps in whole seconds, which would hide an edit within a second. `sources` have names
    without ``.py``, and messages show `folder`. Without `builtins` modules have Python's.
    """

    def __init__(
        self,
        folder: Path,
        absolute: Path,
        sources: Mapping[str, bytes],
        builtins: dict[str, Any] | None = None,
    ) -> None:
        self.sources = sources
        self._builtins = builtins
        self._folder = folder
        self._absolute = absolute
        self.helpers = sources.keys() - SLOTS.keys() - reserved_names(sources)
        self._loaded: dict[str, ModuleType] = {}

    @contextmanager
    def importable(self) -> Iterator[None]:
        """Let the modules be imported inside the context; restore other ones after it."""
        names = {*self.helpers, *map(module_name, (*SLOTS, *self.sources))}
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

    def execute(self, name: str) -> ModuleType:
        """Execute a file that defines callbacks and return its module; only inside `importable`."""
        module = ModuleType(module_name(name))
        module.__file__ = str(self._absolute / f"{name}.py")
        module.__package__ = ""
        # Dataclasses, for example, look up their module there.
        sys.modules[module.__name__] = module
        self.exec_module(module)
        return module

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a helper module; part of the import protocol."""
        if name in self.helpers:
            file = self._absolute / f"{name}.py"
            return importlib.util.spec_from_file_location(name, file, loader=self)
        if name in SLOTS and name in self.sources:
            return self._found_elsewhere(name)
        return None

    def _found_elsewhere(self, slot: str) -> ModuleSpec:
        """Return an installed package with the name of a slot, such as control (python-control)."""
        here = self._absolute.resolve()
        spec = PathFinder.find_spec(slot, [p for p in sys.path if Path(p).resolve() != here])
        if spec is None:
            raise ModuleNotFoundError(
                f"{self._folder / slot}.py is a callback, which other files cannot import: "
                "put shared code into a file of another name",
                name=slot,
            )
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        """Let Python create the module; part of the import protocol."""
        return

    def exec_module(self, module: ModuleType) -> None:
        """Compile and execute the file of a module."""
        stem = module.__name__.removeprefix(_PACKAGE)
        file = str(self._absolute / f"{stem}.py")
        try:
            code = _compiled(self.sources[stem], file)
            if self._builtins is not None:
                module.__dict__["__builtins__"] = self._builtins
            exec(code, module.__dict__)
        except BaseException as error:
            error.add_note(f"while loading {self._folder / stem}.py")
            raise


def module_name(slot: str) -> str:
    return f"{_PACKAGE}{slot}"


def _compiled(source: bytes, file: str) -> Any:
    code, lines = _code_and_lines(source, file)
    # Tracebacks show the lines that were compiled, even if the file has changed since.
    linecache.cache[file] = (len(source), None, lines, file)
    return code


@lru_cache(maxsize=64)  # each run of a campaign executes the same files
def _code_and_lines(source: bytes, file: str) -> tuple[Any, list[str]]:
    text = _decoded(source, file)
    tree = _with_plain_imports(source, file) if _RELATIVE.search(source) else source
    return compile(tree, file, "exec", dont_inherit=True), list(io.StringIO(text))


def _with_plain_imports(source: bytes, file: str) -> Any:
    """Return a syntax tree in which ``from .helper import x`` has no dot."""
    tree = compile(source, file, "exec", ast.PyCF_ONLY_AST, dont_inherit=True)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            if node.module is None:
                said = f"write import {node.names[0].name}"
                raise SyntaxError(said, (file, node.lineno, None, None))
            node.level = 0
    return tree


def _decoded(source: bytes, file: str) -> str:
    problem, offset = "it has null bytes", source.find(b"\0")
    if offset < 0:
        try:
            return importlib.util.decode_source(source)
        except (SyntaxError, UnicodeDecodeError) as error:
            problem, offset = str(error), getattr(error, "start", 0)
    line = source.count(b"\n", 0, offset) + 1
    raise SyntaxError(f"the file is not UTF-8 text: {problem}", (file, line, None, None))


def reserved_names(names: Iterable[str]) -> set[str]:
    return set(names) & _RESERVED
