"""The slots, imports and sizes that a submission may have."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from robsim.base.checks import check_bool, check_int
from robsim.base.spelling import suggestion
from robsim.base.text import quoted
from robsim.simulation.folder_modules import reserved_names
from robsim.simulation.slots import SLOTS, checked_slots

_MODULE = re.compile(r"[A-Za-z_]\w{0,60}(\.[A-Za-z_]\w{0,60}){0,9}")


@dataclass(frozen=True, kw_only=True)
class Rules:
    """The slots, imports and sizes that a submission may have; plain values, also for the worker.

    A wrong value raises TypeError or ValueError with its name.
    """

    slots: tuple[str, ...] = tuple(SLOTS)
    functions: tuple[str, ...] = ()  # in addition; a slot or function is required
    imports: tuple[str, ...] | None = None  # top-level modules besides its own; None = all
    #: Modules, or names in them, such as ``"robsim.estimation.reference"``, ``"robsim.locate"``.
    masked: tuple[str, ...] = ()
    defaults: bool = False
    files: int = 100  # at most
    size: int = 5 * 2**20  # bytes of all files
    file_size: int = 2**20  # bytes of one
    ratio: int = 100  # of the sizes of a file, unpacked and in a zip

    def __post_init__(self) -> None:
        own = object.__setattr__
        own(self, "functions", _functions(self.functions))
        if not isinstance(self.slots, tuple) or self.slots:
            own(self, "slots", checked_slots(self.slots, tuple(SLOTS)))
        if self.imports is not None:
            own(self, "imports", _modules("imports", self.imports))
            if dotted := [name for name in self.imports if "." in name]:
                raise ValueError(f"imports must be top-level modules, got {quoted(dotted[0])}")
        own(self, "masked", _modules("masked", self.masked))
        for name in self.masked:
            _check_there(name)
        check_bool("defaults", self.defaults)
        check_int("files", self.files, minimum=1, maximum=10_000)
        check_int("size", self.size, minimum=1, maximum=2**27)
        check_int("file_size", self.file_size, minimum=1, maximum=2**27)
        check_int("ratio", self.ratio, minimum=1, maximum=10_000)
        if not self.names:
            raise ValueError("slots and functions must have at least one name, got no name")

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.slots, *self.functions)


def _functions(functions: Any) -> tuple[str, ...]:
    if isinstance(functions, Mapping) or not isinstance(functions, Iterable):
        raise TypeError(f"functions must be names, such as ['fit'], got {quoted(functions)}")
    names = (functions,) if isinstance(functions, str) else tuple(functions)
    for name in names:
        if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name):
            raise ValueError(f"functions must be names of functions, got {quoted(name)}")
        if name.startswith("_") or reserved_names([name]):
            raise ValueError(f"functions must not have {name}, which a module may also define")
        if name in SLOTS:
            raise ValueError(f"functions must not have the slot {name}: put {name} into slots")
    if len(set(names)) < len(names):
        raise ValueError(f"functions must have each name once, got {', '.join(names)}")
    return names


def _check_there(name: str) -> None:
    """Raise ValueError for an unknown name of robsim: it would mask nothing."""
    package, _, last = name.rpartition(".")
    if name.partition(".")[0] != "robsim" or not package:
        return
    try:
        if find_spec(name) is not None:
            return
        known = dir(import_module(package))
    except ImportError:  # of its parent package
        known = []
    if last not in known:
        raise ValueError(f"masked: unknown name {name}{suggestion(last, known)}")


def _modules(name: str, modules: Any) -> tuple[str, ...]:
    if isinstance(modules, (str, Mapping)) or not isinstance(modules, Iterable):
        raise TypeError(
            f"{name} must be names of modules, such as ['numpy'], got {quoted(modules)}"
        )
    names = tuple(modules)
    for module in names:
        if not isinstance(module, str) or not _MODULE.fullmatch(module):
            raise ValueError(f"{name} must have names of modules, got {quoted(module)}")
    return names
