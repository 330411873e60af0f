"""What a submission may import: a courtesy that says it in a sentence, and no wall."""

from __future__ import annotations

import builtins
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from robsim.grading._submissions.rules import Rules


class _Masked(MetaPathFinder):
    """A finder that has a sentence in place of each masked module."""

    def __init__(self, masked: Sequence[str]) -> None:
        self._masked = masked

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if mask := _above(name, self._masked):
            raise _not_here(mask)
        return None


def _above(name: str, masked: Sequence[str]) -> str | None:
    """Return the masked module that a module is, or lies in."""
    return next((mask for mask in masked if f"{name}.".startswith(f"{mask}.")), None)


def _not_here(mask: str) -> ImportError:
    return ImportError(f"{mask} is not there for this assignment: do without it", name=mask)


@contextmanager
def masked(rules: Rules) -> Iterator[None]:
    """Take the masked modules away inside the context, also where they were imported before."""
    taken = {name: sys.modules.pop(name) for name in [*sys.modules] if _above(name, rules.masked)}
    attributes = [found for mask in rules.masked if (found := _taken_attribute(mask)) is not None]
    finder = _Masked(rules.masked)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        sys.modules.update(taken)
        for module, name, value in attributes:
            setattr(module, name, value)


def _taken_attribute(mask: str) -> tuple[ModuleType, str, Any] | None:
    """Take a module away from the package that it lies in."""
    package, _, name = mask.rpartition(".")
    module = sys.modules.get(package)
    if module is None or name not in vars(module):
        return None
    value = getattr(module, name)
    delattr(module, name)
    return module, name, value


def builtins_for(rules: Rules, own: Sequence[str]) -> dict[str, Any]:
    """Return the built-in names for a submission's modules, with an ``import`` that keeps to rules.

    Parameters
    ----------
    rules : Rules
        The rules.
    own : sequence of str
        Modules of the submission's own, which may always be imported.
    """
    plain_import = builtins.__import__
    allowed = None if rules.imports is None else {*rules.imports, *own, "__future__"}

    def checked_import(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> ModuleType:
        if not level:
            for whole in (name, *(f"{name}.{inner}" for inner in fromlist or ())):
                if mask := _above(whole, rules.masked):
                    raise _not_here(mask)
            top = name.partition(".")[0]
            if allowed is not None and top not in allowed:
                may = ", ".join(sorted(rules.imports or ())) or "nothing"
                raise ImportError(
                    f"{top} may not be imported in this assignment: there is {may}", name=top
                )
        return plain_import(name, globals, locals, fromlist, level)

    return {**vars(builtins), "__import__": checked_import}
