"""A line of the user's own code (file, number, text), which check reports point to."""

from __future__ import annotations

import functools
import inspect
import linecache
import sysconfig
import traceback
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

_PACKAGE = str(Path(__file__).parent.parent)
# Standard library and site-packages: not the code under test.
_INSTALLED = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib")})


@dataclass(frozen=True)
class SourceLine:
    """A line of the code under test.

    Attributes
    ----------
    file : str
        Path of the file, as in a traceback.
    number : int
        Number of the line, from 1.
    function : str
        Name of the function that contains it.
    """

    file: str
    number: int
    function: str

    @property
    def text(self) -> str:
        """The line itself; empty if it cannot be read."""
        return linecache.getline(self.file, self.number).strip()

    def __str__(self) -> str:
        is_cell = "ipykernel" in self.file or self.file.startswith("<ipython-input")
        file = "line" if is_cell else f"{Path(self.file).name}:"
        return f"{file}{' ' if is_cell else ''}{self.number} in {self.function}"


def line_of_error(error: BaseException) -> SourceLine | None:
    """Return the innermost line of the user's code in a traceback, or None."""
    frames = traceback.walk_tb(error.__traceback__)
    lines = [SourceLine(f.f_code.co_filename, n, f.f_code.co_name) for f, n in frames]
    return next((line for line in reversed(lines) if _is_users(line.file)), None)


def line_of_frame(frame: FrameType | None) -> SourceLine | None:
    """Return the innermost line of the user's code on the stack of a frame, or None."""
    while frame is not None:
        code = frame.f_code
        if _is_users(code.co_filename):
            return SourceLine(code.co_filename, frame.f_lineno, code.co_name)
        frame = frame.f_back
    return None


def line_of_callable(function: Any) -> SourceLine | None:
    """Return where a function, method or callable object is defined; None if it is compiled."""
    while isinstance(function, functools.partial):
        function = function.func
    if isinstance(function, type):
        function = inspect.getattr_static(function, "__init__")
    function = inspect.unwrap(function)
    if not hasattr(function, "__code__"):
        function = inspect.getattr_static(type(function), "__call__", None)
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    return SourceLine(code.co_filename, code.co_firstlineno, code.co_name)


def _is_users(file: str) -> bool:
    if "ipykernel_" in file or file.startswith("<ipython-input"):
        return True
    return not file.startswith((_PACKAGE, *_INSTALLED, "<"))
