"""Text from outside: harmless in a terminal, short in a message, plain in a table."""

from __future__ import annotations

import re
import reprlib
import unicodedata
from collections.abc import Iterable
from contextlib import suppress
from itertools import islice
from typing import Any

_LONGEST_QUOTE = 60  # characters
_MOST_LISTED = 10
_LONGEST_MESSAGE = 200  # characters

_repr = reprlib.Repr()
_repr.maxlevel = 3
_repr.maxstring = _repr.maxother = _repr.maxlong = _LONGEST_QUOTE

# Signs that change the direction of the text around them.
_DIRECTIONS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
# Cc control, Cs half a character, Co private, Zl and Zp other line breaks.
_HARMFUL = frozenset({"Cc", "Cs", "Co", "Zl", "Zp"})


def printable(text: object) -> str:
    """Return a text with its control characters as escapes; line breaks and tabs stay."""
    return _escaped(str(text), kept="\n\t")


def one_line(text: object) -> str:
    """Return a text with its control characters and line breaks as escapes."""
    return _escaped(str(text), kept="")


def _escaped(text: str, kept: str) -> str:
    if text.isprintable():
        return text
    return "".join(
        character if character in kept or not _is_harmful(character) else ascii(character)[1:-1]
        for character in text
    )


def _is_harmful(character: str) -> bool:
    return character in _DIRECTIONS or unicodedata.category(character) in _HARMFUL


def quoted(value: Any) -> str:
    """Return a value's repr for a message, cut to 60 characters."""
    try:
        text = one_line(_repr.repr(value))
    except ValueError:  # Python writes no int of thousands of digits
        return f"a number of {value.bit_length()} bits" if isinstance(value, int) else "a number"
    if len(text) <= _LONGEST_QUOTE:
        return text
    half = (_LONGEST_QUOTE - 3) // 2
    return f"{text[:half]}...{text[-half:]}"


def cut(text: object) -> str:
    """Return a text for a message: in one line, cut to 200 characters."""
    line = one_line(text)
    return line if len(line) <= _LONGEST_MESSAGE else f"{line[: _LONGEST_MESSAGE - 4]} ..."


def said_by(error: BaseException) -> str:
    """Return type and first line of an exception, cut; repr of a user's class may fail."""
    kind, message = "an exception", ""
    with suppress(BaseException):
        kind = str(type(error).__name__)
        message = str(error).partition("\n")[0]
    return cut(f"{kind}: {message}" if message else kind)


def listed(names: Iterable[str]) -> str:
    """Return names from outside as a list in a message: the first ten."""
    names = iter(names)
    shown = [one_line(name)[:_LONGEST_QUOTE] for name in islice(names, _MOST_LISTED)]
    more = sum(1 for _ in names)
    return ", ".join(shown) + (f", ... ({_MOST_LISTED + more} in all)" if more else "")


def is_plain(text: str) -> bool:
    """Return whether a text contains no sign that a spreadsheet may take for the end of a cell."""
    return re.fullmatch(r"[\w .()/^-]*", text) is not None


def as_cell(text: str) -> str:
    """Return a text as a cell of a table in a file, which no program takes for a formula."""
    return f"'{text}" if re.match(r"'*\s*[=+\-@\uff0b\uff0d\uff1d\uff20]|[\t\r\n]", text) else text


def no_formula(text: object) -> str:
    """Return a text for matplotlib to draw unchanged: a dollar sign starts no formula."""
    return one_line(text).replace("$", r"\$")
