"""Python text as tokens that survive renaming, other numbers, comments and another layout."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator
from typing import NamedTuple

# Never fails, whatever the text is: what is no token of Python is one of a single character.
_TOKEN = re.compile(
    r"""
    (?P<import>^[ \t]*(?:import|from)[ \t][^\n]*)
  | (?P<comment>\#[^\n]*)
  | (?P<text>(?i:[rbuft]{0,3})
      (?:'''(?:[^'\\]|\\.|'(?!''))*+(?:'''|\Z)
        |\"""(?:[^"\\]|\\.|"(?!""))*+(?:\"""|\Z)
        |'(?:[^'\\\n]|\\.)*+(?:'|$|\Z)
        |"(?:[^"\\\n]|\\.)*+(?:"|$|\Z)))
  | (?P<number>\.?\d[\w.]*(?:(?<=[eE])[+-]\d+)?)
  | (?P<name>[^\W\d]\w*)
  | (?P<sign>\S)
    """,
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_KEYWORDS = frozenset(keyword.kwlist)
_NAME, _NUMBER, _TEXT = "n", "0", "s"


class Token(NamedTuple):
    """What a token is, and the line it begins in, from 1."""

    kind: str
    line: int


def tokens_of(source: str) -> list[Token]:
    """Return the tokens of a text: keywords, signs, and what is called by others' names.

    Names are all one, but for those of others' modules and values, such as ``inv`` in
    ``np.linalg.inv``; so are numbers and texts. Comments and imports are left out.
    """
    return list(_tokens(source))


def _tokens(source: str) -> Iterator[Token]:
    line, counted = 1, 0
    before = ("", "")
    for match in _TOKEN.finditer(source):
        line += source.count("\n", counted, match.start())
        counted = match.start()
        what, text = match.lastgroup, match.group()
        if what in ("comment", "import"):
            continue
        yield Token(_kind(what, text, before), line)
        before = (before[1], text)


def _kind(what: str | None, text: str, before: tuple[str, str]) -> str:
    if what == "text":
        return _TEXT
    if what == "number":
        return _NUMBER
    if what == "name" and text not in _KEYWORDS:
        is_others = before[1] == "." and before[0] != "self"
        return text if is_others else _NAME
    return text
