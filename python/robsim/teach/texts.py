"""Texts of students: cut, cleaned and fenced before users or files get them."""

from __future__ import annotations

import json
import linecache
import re
import traceback
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from types import FunctionType, WrapperDescriptorType
from typing import Any

from robsim.base.checks import check_int, check_text
from robsim.base.source_line import SourceLine
from robsim.base.text import printable
from robsim.simulation import FailedCallback
from robsim.teach.errors import AssignmentError, GraderError, GradingError, SubmissionError

#: Characters of a text, of a line, of a name.
MOST_TEXT, MOST_LINE, MOST_NAME = 4000, 200, 60
_MOST_SAID = 400  # characters of a message in a sentence
_MOST_LINES = 10  # of a traceback
_MOST_DEPTH = 100_000  # calls of a traceback
_MOST_JSON = 16 * 2**10  # bytes
_CUT = " ..."
# A letter with more marks than any language uses covers the lines around it.
_MARK = r"[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff]"
_MARKS = re.compile(f"({_MARK}{{3}}){_MARK}+")


def clean_text(text: str, most: int = MOST_TEXT) -> str:
    r"""Return a student's text as harmless text, with escapes for invisible characters.

    The result is harmless in a terminal, XML 1.0 and JSON. HTML and Markdown have special
    characters, so escape or fence the text there. The function cuts the text first.

    Parameters
    ----------
    text : str
        The text.
    most : int
        The maximum number of characters of the result.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Examples
    --------
    >>> print(robsim.teach.clean_text("done\x1b[8m, and a hidden text"))
    done\x1b[8m, and a hidden text
    >>> robsim.teach.clean_text("a" * 50, most=12)
    'aaaaaaaa ...'
    """
    check_text("text", text)
    return _cleaned(text, check_int("most", most, minimum=0, maximum=2**31))


def _cleaned(text: object, most: int = MOST_TEXT) -> str:
    """Return the result of `clean_text`; of other objects, the name of the class."""
    if type(text) is not str:
        return f"<{type_name(text)}>"
    start = text[: most + 1].replace("\r\n", "\n").replace("\r", "\n")
    clean = _MARKS.sub(r"\1", printable(start))
    if not clean.replace("\n", "").replace("\t", "").isprintable():
        clean = "".join(c if c in "\n\t" or c.isprintable() else ascii(c)[1:-1] for c in clean)
    if len(text) <= most and len(clean) <= most:
        return clean
    return (clean[: max(most - len(_CUT), 0)] + _CUT)[:most]


def clean_line(text: object, most: int = MOST_LINE) -> str:
    line = _cleaned(text, most).replace("\n", "\\n").replace("\t", " ")
    return line if len(line) <= most else line[: max(most - len(_CUT), 0)] + _CUT


def fenced(text: str, most: int = MOST_TEXT) -> str:
    """Return a student's text, cleaned, as a block of Markdown that the text cannot end.

    Parameters
    ----------
    text, most
        See `clean_text`.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Examples
    --------
    >>> print(robsim.teach.fenced("a ``` b"))
    ````text
    a ``` b
    ````
    """
    clean = clean_text(text, most)
    longest = max((len(run) for run in re.findall(r"`+", clean)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{clean}\n{fence}"


def type_name(value: object) -> str:
    """Return the name of a value's class without calling any code of the value."""
    return clean_line(type.__dict__["__name__"].__get__(type(value)), MOST_NAME)


@dataclass(frozen=True)
class ErrorText:
    """The text of an exception of a submission."""

    #: Class and text of the exception; a `SubmissionError` has no class.
    type: str
    message: str
    lines: tuple[str, ...] = ()  # the lines of the submission that led to it, the innermost last
    slot: str | None = None
    step: int | None = None  # None = at the start, or earlier
    file: str | None = None  # file, or cell of a notebook, of the innermost line
    line: int | None = None

    @property
    def place(self) -> str:
        """Slot, step, file and line, as far as known."""
        parts = []
        if self.slot is not None:
            parts.append(self.slot if self.step is None else f"{self.slot} at step {self.step}")
        if self.file is not None:
            parts.append(self.file if self.line is None else f"{self.file}, line {self.line}")
        return ", ".join(parts)

    def __str__(self) -> str:
        """Place, class and message in one sentence, cut."""
        if not self.type:
            return self.message
        message = _cleaned(self.message, _MOST_SAID)
        said = f"{self.type}: {message}" if message else self.type
        return f"{self.place}: {said}" if self.place else said

    def as_error(self) -> SubmissionError:
        places: dict[str, Any] = {"slot": self.slot, "step": self.step}
        return SubmissionError(str(self), **places, file=self.file, line=self.line)

    def to_json(self) -> bytes:
        """Return the text as JSON of at most 16 KiB, without its lines if they do not fit."""
        short = self
        while len(data := json.dumps(vars(short), ensure_ascii=False).encode()) > _MOST_JSON:
            most = len(short.message) if short.lines else len(short.message) // 2
            short = replace(short, lines=short.lines[1:], message=_cleaned(short.message, most))
        return data

    @classmethod
    def from_json(cls, data: bytes) -> ErrorText:
        """Return the error of an untrusted worker; raise ValueError if it is invalid."""
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
            message=_cleaned(fields.get("message", "")),
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
    """Return the text of an exception, without a call of the submission's code.

    Slot and step are defaults for an exception without a place.
    """
    try:
        return _error_text(error, slot, step)
    except BaseException:  # of a manipulated object
        return ErrorText(type_name(error), "", (), slot, step)


def _error_text(error: BaseException, slot: str | None, step: int | None) -> ErrorText:
    lines = _lines(error)
    # A SubmissionError raised by the submission is one of its exceptions, without our text.
    if type(error) in (SubmissionError, AssignmentError, GraderError) and not lines:
        assert isinstance(error, GradingError)
        text = _cleaned(str(error))
        return ErrorText("", text, (), error.slot, error.step, error.file, error.line)
    last = lines[-1] if lines else None
    noted = _noted(error)
    if noted is not None:
        slot, step = noted.slot, noted.k
        last = noted.source if last is None and type(noted.source) is SourceLine else last
    if issubclass(type(error), SyntaxError) and (at := _line_of_syntax(error)) is not None:
        lines.append(at)
        last = at
    return ErrorText(
        type=type_name(error),
        message=_message(error),
        lines=tuple(map(_told, lines)),
        slot=None if slot is None else clean_line(slot, MOST_NAME),
        step=_number(step),
        file=None if last is None else _file_of(last),
        line=None if last is None else _number(last.number),
    )


def _noted(error: BaseException) -> FailedCallback | None:
    """Return the loop's note on an exception, like `callback_of`, without any calls."""
    attributes = BaseException.__dict__["__dict__"].__get__(error)
    found = dict.get(attributes, "callback")
    return found if type(found) is FailedCallback else None


def _lines(error: BaseException) -> list[SourceLine]:
    newest: deque[SourceLine] = deque(maxlen=_MOST_LINES)
    trace = BaseException.__dict__["__traceback__"].__get__(error)
    for frame, number in islice(traceback.walk_tb(trace), _MOST_DEPTH):
        line = SourceLine(frame.f_code.co_filename, number or 0, frame.f_code.co_name)
        if line.is_users:
            newest.append(line)
    return list(newest)


def _line_of_syntax(error: BaseException) -> SourceLine | None:
    file, number = (SyntaxError.__dict__[name].__get__(error) for name in ("filename", "lineno"))
    if type(file) is not str or type(number) is not int:
        return None
    line = SourceLine(file, number, "<module>")
    return line if line.is_users else None


def _source(line: SourceLine) -> str:
    """Return the text of a loaded line without opening any file."""
    entry = linecache.cache.get(line.file)
    lines = entry[2] if isinstance(entry, tuple) and len(entry) == 4 else []
    return clean_line(lines[line.number - 1].strip()) if 0 < line.number <= len(lines) else ""


def _file_of(line: SourceLine) -> str:
    place = line.place
    for end in (f", line {line.number}", f":{line.number}"):
        place = place.removesuffix(end)
    return clean_line(place, MOST_NAME)


def _told(line: SourceLine) -> str:
    function = "" if line.function == "<module>" else f" in {clean_line(line.function, MOST_NAME)}"
    place = f"{_file_of(line)}, line {line.number}{function}"
    source = _source(line)
    return f"{place}: {source}" if source else place


def _message(error: BaseException) -> str:
    """Return the text of an exception; only its class if the text may be endless or long."""
    args = BaseException.__dict__["args"].__get__(error)
    kind = type(error)
    if args and type(args[0]) is str and (len(args) == 1 or issubclass(kind, SyntaxError)):
        return f"{args[0][:MOST_NAME]!r}" if issubclass(kind, KeyError) else _cleaned(args[0])
    if all(map(_is_plain, args)) and not _is_users(_method(kind, "__str__")):
        with suppress(BaseException):
            return _cleaned(str(error))
    return _cleaned(", ".join(map(_shown, args[:5])))


def _is_plain(value: Any) -> bool:
    kind = type(value)
    if kind in (str, bytes):
        return len(value) <= MOST_TEXT
    return kind in (int, float, bool, complex, type(None)) and (
        kind is not int or value.bit_length() <= 1000
    )


def _shown(value: Any) -> str:
    if type(value) is str:
        return _cleaned(value)
    return _cleaned(repr(value)) if _is_plain(value) else f"<{type_name(value)}>"


def _method(kind: type, name: str) -> object:
    """Return a class's attribute of some name, also from its bases."""
    for each in type.__dict__["__mro__"].__get__(kind):
        own = type.__dict__["__dict__"].__get__(each)
        if name in own:
            return own[name]
    return None


def _is_users(method: object) -> bool:
    """Return whether a method may be the submission's, not Python's or a package's."""
    if type(method) is FunctionType:
        return SourceLine(method.__code__.co_filename, 0, "").is_users
    return type(method) is not WrapperDescriptorType
