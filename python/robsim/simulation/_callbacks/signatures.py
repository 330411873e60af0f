"""With how many arguments a callable can be called, as far as that can be known."""

from __future__ import annotations

import inspect
from collections.abc import Callable

from robsim._base.source_line import users_line_of_callable


def accepts(function: Callable[..., object], count: int) -> bool:
    """Return whether a callable can be called with so many positional arguments.

    True for compiled callables that do not say what they take.
    """
    signature = signature_of(function)
    if signature is None:
        return True
    try:
        signature.bind(*[None] * count)
    except TypeError:
        return False
    return True


def signature_of(function: Callable[..., object]) -> inspect.Signature | None:
    """Return the signature of a callable, None if it is not known."""
    try:
        return inspect.signature(function)
    except (TypeError, ValueError):  # of compiled objects
        return None


def where_defined(function: Callable[..., object]) -> str:
    """Return signature and place of a callable, as ``(a, b) (control.py:3)``."""
    return f"{signature_of(function) or '(...)'}{place_of(function)}"


def place_of(function: Callable[..., object]) -> str:
    """Return where the user has defined a callable, as `` (control.py:3)``; else ``""``."""
    line = users_line_of_callable(function)
    return "" if line is None else f" ({line.place})"
