"""A line of the user's own code (file, number, text), which check reports point to."""

from __future__ import annotations

import ast
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
    r"""A line of the code under test.

    Attributes
    ----------
    file : str
        Path of the file, as in a traceback.
    number : int
        Number of the line, from 1.
    function : str
        Name of the function that contains it.

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("mine").mkdir()
    >>> size = Path("mine/control.py").write_text("def control(step):\n    return 1 / step.k")
    >>> line = robsim.teach.check_folder("mine").problems[0].line
    >>> print(line, "has", line.text)
    control.py:2 in control has return 1 / step.k
    """

    file: str
    number: int
    function: str

    @property
    def text(self) -> str:
        """The line itself; empty if it cannot be read."""
        return linecache.getline(self.file, self.number).strip()

    @property
    def place(self) -> str:
        """File and line number, such as ``control.py:3``, or ``line 3`` in a running notebook."""
        if _is_cell(self.file):
            return f"line {self.number}"
        name = Path(self.file).name
        return f"{name}, line {self.number}" if ".ipynb, cell " in name else f"{name}:{self.number}"

    @property
    def is_users(self) -> bool:
        """Whether the line is the user's own code, not code of robsim or an installed package."""
        return _is_users(self.file)

    def __str__(self) -> str:
        return f"{self.place} in {self.function}"


def line_of_error(error: BaseException) -> SourceLine | None:
    """Return the innermost line of the user's code in a traceback, or None."""
    frames = traceback.walk_tb(error.__traceback__)
    lines = [SourceLine(f.f_code.co_filename, n, f.f_code.co_name) for f, n in frames]
    return next((line for line in reversed(lines) if _is_users(line.file)), None)


def called_in(error: BaseException) -> str | None:
    """Return the name of the compiled function that the last line of a traceback calls, or None."""
    frames = traceback.extract_tb(error.__traceback__, -1)
    if not frames:
        return None
    last = frames[0]
    lines = linecache.getlines(last.filename)[(last.lineno or 1) - 1 : last.end_lineno]
    if not lines or last.colno is None or last.end_colno is None:
        return None
    # Offsets count bytes.
    lines[-1] = lines[-1].encode()[: last.end_colno].decode()
    lines[0] = lines[0].encode()[last.colno :].decode()
    try:
        call = ast.parse("".join(lines), mode="eval").body
    except SyntaxError:
        return None
    if not isinstance(call, ast.Call):
        return None
    return getattr(call.func, "attr", getattr(call.func, "id", None))


def line_of_frame(frame: FrameType | None) -> SourceLine | None:
    """Return the innermost line of the user's code on the stack of a frame, or None."""
    while frame is not None:
        code = frame.f_code
        if _is_users(code.co_filename):
            return SourceLine(code.co_filename, frame.f_lineno, code.co_name)
        frame = frame.f_back
    return None


def inner_of(function: Any) -> Any:
    """Return the function inside of partial ones."""
    while isinstance(function, functools.partial):
        function = function.func
    return function


def line_of_callable(function: Any) -> SourceLine | None:
    """Return the place where a function, method or callable object is defined; None: compiled."""
    function = inner_of(function)
    if isinstance(function, type):
        function = inspect.getattr_static(function, "__init__")
    function = inspect.unwrap(function)
    if not hasattr(function, "__code__"):
        function = inspect.getattr_static(type(function), "__call__", None)
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    return SourceLine(code.co_filename, code.co_firstlineno, code.co_name)


def users_line_of_callable(function: Any) -> SourceLine | None:
    """Return the same, None if the code is not the user's."""
    line = line_of_callable(function)
    return line if line is not None and line.is_users else None


def _is_cell(file: str) -> bool:
    return "ipykernel_" in file or file.startswith("<ipython-input")


def _is_users(file: str) -> bool:
    return _is_cell(file) or not file.startswith((_PACKAGE, *_INSTALLED, "<"))
