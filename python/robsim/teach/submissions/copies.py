"""Copies of masked functions: code of robsim's files that a submission runs again."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

_LEAST = 200  # bytes of code: a shorter function may equal another by chance

_Body = tuple[bytes, tuple[str, ...]]  # without names of variables

_refused: list[dict[_Body, str]] = []


@contextmanager
def copies_refused(masked: Mapping[str, Any]) -> Iterator[None]:
    """Refuse with ImportError, inside the context, to run code with a function of masked objects.

    A mask of a module or a package has None.
    """
    bodies = {body: mask for mask, value in masked.items() for body in _bodies(mask, value)}
    _listen()
    _refused.append(bodies)
    try:
        yield
    finally:
        _refused.remove(bodies)


def _bodies(mask: str, value: Any) -> Iterator[_Body]:
    if not mask.startswith("robsim.") or mask.startswith("robsim.teach."):
        return
    for code in codes_of_files(mask) if value is None else codes_of(value):
        if len(code.co_code) >= _LEAST:
            yield code.co_code, code.co_names


def codes_of(value: Any) -> Iterator[CodeType]:
    """Yield the codes of a function, or of the methods of a class of robsim and of its bases."""
    parts = [part for kind in getattr(value, "__mro__", ()) for part in vars(kind).values()]
    for part in (value, *parts):
        # Methods of dataclasses come from no file, and other dataclasses have the same.
        if isinstance(part, FunctionType) and "robsim" in Path(part.__code__.co_filename).parts:
            yield part.__code__


@cache
def codes_of_files(mask: str) -> tuple[CodeType, ...]:
    """Return the codes in the files of a module or package, nested ones, too."""
    with suppress(ImportError, PermissionError):  # in a worker, which has no masked files
        spec = find_spec(mask)
        if spec is not None and spec.origin is not None:
            file = Path(spec.origin)
            files = file.parent.rglob("*.py") if spec.submodule_search_locations else [file]
            loaders = [SourceFileLoader(mask, str(file)) for file in files]
            return tuple(code for loader in loaders for code in _nested(loader.get_code(mask)))
    return ()


def _nested(code: CodeType | None) -> Iterator[CodeType]:
    if code is not None:
        yield code
        for constant in code.co_consts:
            yield from _nested(constant if isinstance(constant, CodeType) else None)


@cache
def _listen() -> None:
    sys.addaudithook(_refuse)  # forever: Python cannot remove a hook


def _refuse(event: str, arguments: tuple[Any, ...]) -> None:
    if not _refused or event not in ("exec", "function.__new__"):
        return
    for code in _nested(arguments[0]):
        for bodies in _refused:
            if mask := bodies.get((code.co_code, code.co_names)):
                raise ImportError(f"this is a copy of {mask}: write your own code", name=mask)


codes_of_files("robsim.estimation.reference")  # before the worker's sandbox hides the file
