"""The callbacks of a submission, from its sources; this module runs its code."""

from __future__ import annotations

import ast
import io
import linecache
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from importlib import import_module
from os import PathLike
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any

from robsim.base.text import one_line, quoted
from robsim.simulation.callback_folder import CallbackFolder, callback_of_module
from robsim.simulation.folder_modules import FolderModules, module_name
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.files import FILE, FOLDER, NOTEBOOK, SubmissionFiles
from robsim.teach.submissions.handed_in import own_slots
from robsim.teach.submissions.imports import builtins_for, masked
from robsim.teach.submissions.notebook.choosing import chosen
from robsim.teach.submissions.notebook.statements import FILLED, Fill
from robsim.teach.submissions.python_text import statements_of
from robsim.teach.submissions.rules import Rules
from robsim.teach.texts import error_text

Callbacks = dict[str, Callable[..., Any] | bool]

_MODULE = "notebook"

_for_good: list[AbstractContextManager[Callbacks]] = []


def load_slots(
    files: SubmissionFiles, rules: Rules, folder: str | PathLike[str] | None = None
) -> Callbacks:
    """Load a submission for the rest of the process: a worker does this once.

    Return its callbacks by slot, and its functions by name. False is a switched off slot, True the
    default stage. The folder has its data files, for its ``__file__``. A SubmissionError has slot
    and line of faulty code.
    """
    context = loaded_slots(files, rules, folder, for_good=True)
    callbacks = context.__enter__()
    _for_good.append(context)  # its end would undo the load
    return callbacks


@contextmanager
def loaded_slots(
    files: SubmissionFiles,
    rules: Rules,
    folder: str | PathLike[str] | None = None,
    *,
    for_good: bool = False,
) -> Iterator[Callbacks]:
    """Load a submission as `load_slots`; inside, its callbacks import each other's modules."""
    where = Path(files.name) if folder is None else Path(folder).absolute()
    load = _folder if files.kind == FOLDER else _module
    with ExitStack() as stack:
        taken = stack.enter_context(masked(rules, for_good=for_good))
        own = builtins_for(rules, [*files.modules], taken)
        callbacks = stack.enter_context(load(files, where, rules, own))
        with _failing(files.name, None):
            if not rules.defaults:
                statements = partial(statements_of_slot, files, rules)
                callbacks = own_slots(callbacks, rules.slots, taken, statements)
        yield callbacks


def statements_of_slot(files: SubmissionFiles, rules: Rules, slot: str) -> Iterator[ast.stmt]:
    """Yield the top-level statements of a slot's module, or the used statements of a notebook."""
    if files.kind != NOTEBOOK:
        module = slot if files.kind == FOLDER else PurePosixPath(files.main).stem
        yield from statements_of(files.modules[module], f"{module}.py")
        return
    for part in chosen(files.sources[files.main], files.main, rules.names).parts:
        filled = ast.unparse(part.value) if isinstance(part, Fill) else ""
        if not filled.removesuffix("()").isidentifier():  # of a value from another statement
            yield part.node


@contextmanager
def _folder(
    files: SubmissionFiles, where: Path, rules: Rules, own: dict[str, Any]
) -> Iterator[Callbacks]:
    with _failing(files.name, None):
        slots = [slot for slot in files.slots if slot in SLOTS]
        folder, callbacks = CallbackFolder.of_sources(Path(), where, files.modules, slots, own)
    with folder.importable():
        for name in files.slots:
            if name not in SLOTS:  # a module like others, of one file
                with _failing(f"{name}.py", name):
                    callbacks[name] = _function(import_module(name), name, f"{name}.py")
        yield callbacks


@contextmanager
def _module(
    files: SubmissionFiles, where: Path, rules: Rules, own: dict[str, Any]
) -> Iterator[Callbacks]:
    main = PurePosixPath(files.main)
    helpers = {name: source for name, source in files.modules.items() if name not in SLOTS}
    modules = FolderModules(Path(), where, helpers, own)
    with modules.importable(), ExitStack() as after:
        after.callback(sys.modules.pop, module_name(_MODULE), None)
        with _failing(files.main, None):
            if files.kind == FILE:
                module = modules.execute(main.stem)
            else:
                module = _notebook(files, where, rules, own)
        callbacks = {}
        for slot in files.slots:
            with _failing(files.main, slot):
                if slot in SLOTS:
                    callbacks[slot] = callback_of_module(module, slot, Path(files.main))
                else:
                    callbacks[slot] = _function(module, slot, files.main)
        yield callbacks


def _function(module: ModuleType, name: str, file: str) -> Callable[..., Any]:
    if name not in vars(module):
        raise ValueError(f"{one_line(file)} must define {name}(...)")
    function: Callable[..., Any] = vars(module)[name]
    if not callable(function):
        raise TypeError(f"{one_line(file)}: {name} must be a function, got {quoted(function)}")
    return function


def _notebook(files: SubmissionFiles, where: Path, rules: Rules, own: dict[str, Any]) -> ModuleType:
    module = ModuleType(module_name(_MODULE))
    module.__file__ = str(where / files.main)
    vars(module)["__builtins__"] = own
    sys.modules[module.__name__] = module  # dataclasses need it there
    filled = run_cells(files.sources[files.main], files.main, rules.names, vars(module))
    face = ModuleType(module.__name__)  # because a notebook may use a slot's name otherwise
    vars(face).update(filled)
    return face


def run_cells(
    content: bytes, file: str, names: Sequence[str], module: dict[str, Any]
) -> dict[str, Any]:
    """Run the used parts of a notebook with a module's variables; return its values of slots."""
    notebook = chosen(content, file, tuple(names))
    lost: ImportError | None = None
    for cell in {part.cell for part in notebook.parts}:
        lines = [*io.StringIO(cell.source)]
        linecache.cache[cell.place] = (len(cell.source), None, lines, cell.place)
    for part in notebook.parts:
        try:
            exec(part.code, module)
        except ImportError as error:
            if not part.is_star:
                raise
            lost = error  # of names that may be unused
        except NameError as error:
            raise lost or error from None
    for name, unknown in notebook.unknown.items():
        if name not in module:
            raise lost or unknown
    return {slot: module[f"{FILLED}{slot}"] for slot in notebook.slots}


@contextmanager
def _failing(name: str, slot: str | None) -> Iterator[None]:
    """Attribute an exception of the submission's code to the submission."""
    try:
        yield
    except (SubmissionError, KeyboardInterrupt):
        raise
    except BaseException as error:  # SystemExit, too
        text = error_text(error, slot=slot)
        if text.lines:
            told = f"{replace(text, slot=None)}"
            told += f" (when {text.slot} was loaded)" if text.slot is not None else ""
        else:  # an error of robsim about a callback, which names its file
            told = text.message
        raise SubmissionError(told, slot=text.slot, file=text.file, line=text.line) from None
