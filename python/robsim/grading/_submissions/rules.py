"""What a submission may fill, import and weigh."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from robsim._base.checks import check_int
from robsim._base.spelling import suggestion
from robsim._base.text import quoted
from robsim.simulation._slots import SLOTS, checked_slots

_MODULE = re.compile(r"[A-Za-z_]\w{0,60}(\.[A-Za-z_]\w{0,60}){0,9}")


@dataclass(frozen=True, kw_only=True)
class Rules:
    """What a submission may fill, import and weigh; plain values, which go to the worker, too.

    Parameters
    ----------
    slots : sequence of str
        The slots that it may fill; at least one of them it must.
    imports : sequence of str or None
        Top-level modules that it may import beside its own; None = all that the worker has.
    masked : sequence of str
        Modules, with all that is in them, and names of modules that it cannot have, such as
        ``"robsim.reference"`` and ``"robsim.locate"``.
    files : int
        Most files.
    size, file_size : int
        Most bytes of all files, and of one.
    ratio : int
        How many times smaller a file may be in a zip.

    Raises
    ------
    TypeError, ValueError
        If a value cannot be used; the message names it.
    """

    slots: tuple[str, ...] = tuple(SLOTS)
    imports: tuple[str, ...] | None = None
    masked: tuple[str, ...] = ()
    files: int = 100
    size: int = 5 * 2**20
    file_size: int = 2**20
    ratio: int = 100

    def __post_init__(self) -> None:
        own = object.__setattr__
        own(self, "slots", checked_slots(self.slots, tuple(SLOTS)))
        if self.imports is not None:
            own(self, "imports", _modules("imports", self.imports))
            if dotted := [name for name in self.imports if "." in name]:
                raise ValueError(f"imports must be top-level modules, got {quoted(dotted[0])}")
        own(self, "masked", _modules("masked", self.masked))
        for name in self.masked:
            _check_there(name)
        check_int("files", self.files, minimum=1, maximum=10_000)
        check_int("size", self.size, minimum=1, maximum=2**27)
        check_int("file_size", self.file_size, minimum=1, maximum=2**27)
        check_int("ratio", self.ratio, minimum=1, maximum=10_000)

    def to_dict(self) -> dict[str, Any]:
        """Return the rules as data that JSON can hold."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Rules:
        """Return the rules of `to_dict`; raise what the class raises."""
        return cls(**data)


def _check_there(name: str) -> None:
    """Raise ValueError for a name of robsim's that there is not: it would mask nothing."""
    package, _, last = name.rpartition(".")
    if name.partition(".")[0] != "robsim" or not package:
        return
    try:
        if find_spec(name) is not None:
            return
        known = dir(import_module(package))
    except ImportError:  # of what lies above it
        known = []
    if last not in known:
        raise ValueError(f"masked: there is no {name}{suggestion(last, known)}")


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
