"""Texts of students: cut, cleaned and fenced before they reach anybody, or any file."""

from __future__ import annotations

import json
import re
import traceback
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from robsim._base.source_line import SourceLine
from robsim._base.text import printable
from robsim.grading._errors import GradingError, SubmissionError
from robsim.simulation._callbacks.errors import callback_of

#: Characters of a text, of a line, of a name.
MOST_TEXT, MOST_LINE, MOST_NAME = 4000, 200, 60
_MOST_LINES = 10  # of a traceback
_MOST_DEPTH = 100_000  # calls of a traceback
_MOST_JSON = 16 * 2**10  # bytes
_CUT = " ..."
# A letter with more marks than any language puts on it covers the lines around it.
_MARK = r"[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff]"
_MARKS = re.compile(f"({_MARK}{{3}}){_MARK}+")


def clean_text(text: object, most: int = MOST_TEXT) -> str:
    """Return a text of a student's as harmless text: what cannot be seen stands as escapes.

    It is harmless in a terminal, and can stand in XML 1.0 and JSON; HTML and Markdown have their
    own signs, for which there are `html.escape` and `fenced`. It is cut before it is looked at.

    Parameters
    ----------
    text : str
        The text; of anything else only the name of its class is told.
    most : int
        How many characters it may have.
    """
    if type(text) is not str:
        return f"<{type_name(text)}>"
    start = text[: most + 1].replace("\r\n", "\n").replace("\r", "\n")
    clean = _MARKS.sub(r"\1", printable(start))
    if not clean.replace("\n", "").replace("\t", "").isprintable():
        clean = "".join(c if c in "\n\t" or c.isprintable() else ascii(c)[1:-1] for c in clean)
    if len(text) <= most and len(clean) <= most:
        return clean
    return clean[: max(most - len(_CUT), 0)] + _CUT


def clean_line(text: object, most: int = MOST_LINE) -> str:
    """Return the same in one line."""
    line = clean_text(text, most).replace("\n", "\\n").replace("\t", " ")
    return line if len(line) <= most else line[: max(most - len(_CUT), 0)] + _CUT


def fenced(text: object, most: int = MOST_TEXT) -> str:
    """Return a text as a block of Markdown that it cannot end by itself."""
    clean = clean_text(text, most)
    longest = max((len(run) for run in re.findall(r"`+", clean)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{clean}\n{fence}"


def type_name(value: object) -> str:
    """Return the name of a value's class; nothing of the value is called."""
    return clean_line(type.__dict__["__name__"].__get__(type(value)), MOST_NAME)


@dataclass(frozen=True)
class ErrorText:
    """What is told of an exception of a submission.

    Attributes
    ----------
    type, message : str
        Class and text of the exception; no class, where the text says all: of a `SubmissionError`.
    lines : tuple of str
        The lines of the submission that led to it, the innermost last.
    slot : str or None
        The slot.
    step : int or None
        The step; None = at the start, or before it.
    file : str or None
        File, or cell of a notebook, of the innermost line.
    line : int or None
        Its number.
    """

    type: str
    message: str
    lines: tuple[str, ...] = ()
    slot: str | None = None
    step: int | None = None
    file: str | None = None
    line: int | None = None

    @property
    def place(self) -> str:
        """Slot, step, file and line, as far as they are known."""
        parts = []
        if self.slot is not None:
            parts.append(self.slot if self.step is None else f"{self.slot} at step {self.step}")
        if self.file is not None:
            parts.append(self.file if self.line is None else f"{self.file}, line {self.line}")
        return ", ".join(parts)

    def __str__(self) -> str:
        """Place, class and message in one sentence."""
        if not self.type:
            return self.message
        said = f"{self.type}: {self.message}" if self.message else self.type
        return f"{self.place}: {said}" if self.place else said

    def as_error(self) -> SubmissionError:
        """Return the error that tells it."""
        places: dict[str, Any] = {"slot": self.slot, "step": self.step}
        return SubmissionError(str(self), **places, file=self.file, line=self.line)

    def to_json(self) -> bytes:
        """Return it as JSON of at most 16 KiB."""
        lines = self.lines
        while True:
            fields = vars(self) | {"lines": lines}
            text = json.dumps(fields).encode("ascii")
            if len(text) <= _MOST_JSON or not lines:
                return text
            lines = lines[1:]

    @classmethod
    def from_json(cls, data: bytes) -> ErrorText:
        """Return what a worker tells; nothing of it is believed.

        Raises
        ------
        ValueError
            If it is not what `to_json` writes.
        """
        if len(data) > _MOST_JSON:
            raise ValueError(f"an error must have at most {_MOST_JSON} bytes, got {len(data)}")
        try:
            fields = json.loads(data.decode("utf-8"))
        except (ValueError, RecursionError):
            raise ValueError("an error must be JSON text") from None
        if not isinstance(fields, dict):
            raise ValueError("an error must be a JSON object")
        lines = fields.get("lines")
        return cls(
            type=clean_line(fields.get("type", "Exception"), MOST_NAME),
            message=clean_text(fields.get("message", "")),
            lines=tuple(map(clean_line, lines[-_MOST_LINES:])) if isinstance(lines, list) else (),
            slot=_text(fields.get("slot")),
            step=_number(fields.get("step")),
            file=_text(fields.get("file")),
            line=_number(fields.get("line")),
        )


def _text(value: object) -> str | None:
    return clean_line(value, MOST_NAME) if isinstance(value, str) else None


def _number(value: object) -> int | None:
    return value if type(value) is int and 0 <= value < 2**53 else None


def error_text(
    error: BaseException, *, slot: str | None = None, step: int | None = None
) -> ErrorText:
    """Return what is told of an exception: nothing of the submission's is called for it.

    Parameters
    ----------
    error : BaseException
        The exception.
    slot, step
        Where it came, where the exception itself does not say.
    """
    if isinstance(error, GradingError):
        return ErrorText(
            "", clean_text(str(error)), (), error.slot, error.step, error.file, error.line
        )
    found = callback_of(error) if _has_plain_attributes(error) else None
    if found is not None:
        slot, step = found.slot, found.k
    lines = _lines(error)
    last = found.source if found is not None and found.source is not None else None
    last = lines[-1] if lines else last
    if isinstance(error, SyntaxError) and (at := _line_of_syntax(error)) is not None:
        last = at
        lines.append(at)
    file, number = (None, None) if last is None else (_file_of(last), last.number)
    return ErrorText(
        type=type_name(error),
        message=_message(error),
        lines=tuple(map(_told, lines)),
        slot=None if slot is None else clean_line(slot, MOST_NAME),
        step=step,
        file=file,
        line=number,
    )


def _has_plain_attributes(error: BaseException) -> bool:
    """Return whether to look for an attribute runs nothing of the submission's."""
    return not any(
        isinstance(vars(kind).get(name), FunctionType)
        for kind in type.__dict__["__mro__"].__get__(type(error))
        for name in ("__getattribute__", "__getattr__", "callback")
        if _is_users(vars(kind).get(name))
    )


def _lines(error: BaseException) -> list[SourceLine]:
    """Return the submission's own lines in a traceback, the innermost last."""
    newest: deque[SourceLine] = deque(maxlen=_MOST_LINES)
    for line in _walked(error):
        if line.is_users:
            newest.append(line)
    return list(newest)


def _walked(error: BaseException) -> Iterator[SourceLine]:
    trace = BaseException.__dict__["__traceback__"].__get__(error)
    for count, (frame, number) in enumerate(traceback.walk_tb(trace)):
        if count == _MOST_DEPTH:
            return
        code = frame.f_code
        yield SourceLine(str(code.co_filename), number or 0, str(code.co_name))


def _line_of_syntax(error: SyntaxError) -> SourceLine | None:
    file, number = (SyntaxError.__dict__[name].__get__(error) for name in ("filename", "lineno"))
    if type(file) is not str or type(number) is not int:
        return None
    line = SourceLine(file, number, "<module>")
    return line if line.is_users else None


def _file_of(line: SourceLine) -> str:
    return clean_line(
        line.place.rpartition(f", line {line.number}")[0] or line.place.rpartition(":")[0],
        MOST_NAME,
    )


def _told(line: SourceLine) -> str:
    function = "" if line.function == "<module>" else f" in {clean_line(line.function, MOST_NAME)}"
    source = clean_line(line.text)
    place = f"{_file_of(line)}, line {line.number}{function}"
    return f"{place}: {source}" if source else place


def _message(error: BaseException) -> str:
    """Return the text of an exception; of what may never end, or has any length, only its class."""
    args = BaseException.__dict__["args"].__get__(error)
    if isinstance(error, SyntaxError):
        return clean_text(args[0]) if args else ""
    if len(args) == 1 and type(args[0]) is str:
        return clean_text(args[0])
    if all(_is_plain(value) for value in args) and not _is_users(_str_of(error)):
        try:
            return clean_text(str(error))
        except BaseException:
            return ""
    return ", ".join(_shown(value) for value in args[:5])


def _is_plain(value: Any) -> bool:
    kind = type(value)
    if kind in (str, bytes):
        return len(value) <= MOST_TEXT
    return kind in (int, float, bool, complex, type(None)) and (
        kind is not int or value.bit_length() <= 1000
    )


def _shown(value: Any) -> str:
    if type(value) is str:
        return clean_text(value)
    return clean_text(repr(value)) if _is_plain(value) else f"<{type_name(value)}>"


def _str_of(error: BaseException) -> object:
    """Return the method that makes the text of an exception."""
    for kind in type.__dict__["__mro__"].__get__(type(error)):
        if "__str__" in vars(kind):
            return vars(kind)["__str__"]
    return None


def _is_users(function: object) -> bool:
    """Return whether a method may be the submission's, and not of Python or of a package."""
    if not isinstance(function, FunctionType):
        return function is not None and type(function).__name__ not in _BUILT_IN
    return SourceLine(str(function.__code__.co_filename), 0, "").is_users


_BUILT_IN = ("wrapper_descriptor", "method_descriptor", "getset_descriptor", "member_descriptor")
