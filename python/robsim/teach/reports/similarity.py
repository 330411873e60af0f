"""Pairs of submissions that have much of their programs in common, and which part."""

from __future__ import annotations

import keyword
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from itertools import combinations
from typing import NamedTuple

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.notebook.cells import cells_of

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
    tokens = []
    line, counted = 1, 0
    before = ("", "")
    for match in _TOKEN.finditer(source):
        line += source.count("\n", counted, match.start())
        counted = match.start()
        what, text = match.lastgroup, match.group()
        if what in ("comment", "import"):
            continue
        tokens.append(Token(_kind(what, text, before), line))
        before = (before[1], text)
    return tokens


def _kind(what: str | None, text: str, before: tuple[str, str]) -> str:
    if what == "text":
        return _TEXT
    if what == "number":
        return _NUMBER
    if what == "name" and text not in _KEYWORDS:
        is_others = before[1] == "." and before[0] != "self"
        return text if is_others else _NAME
    return text


#: Runs of so many tokens are compared, some two lines; one in each window is kept.
RUN, WINDOW = 20, 8
_MOST_TEXT = 200_000  # characters of a submission; the rest is not compared


@dataclass(frozen=True)
class Piece:
    """A file, or a cell of a notebook, and its text."""

    file: str
    text: str


class Print(NamedTuple):
    """A fingerprint: the hash, the number of the piece, and the lines it covers."""

    hash: bytes
    piece: int
    first_line: int
    last_line: int


@dataclass(frozen=True)
class Program:
    """What was handed in, as it is compared."""

    pieces: tuple[Piece, ...]

    @cached_property
    def prints(self) -> tuple[Print, ...]:
        return tuple(
            each
            for number, piece in enumerate(self.pieces)
            for each in winnowed(tokens_of(piece.text), number)
        )


def program_of(sources: Mapping[str, bytes]) -> Program:
    """Return the Python files and notebooks among files, by their names."""
    pieces: list[Piece] = []
    left = _MOST_TEXT
    for file, content in sorted(sources.items()):
        for piece in _pieces(file, content):
            if left > 0:
                pieces.append(Piece(piece.file, piece.text[:left]))
                left -= len(piece.text)
    return Program(tuple(pieces))


def _pieces(file: str, content: bytes) -> list[Piece]:
    if file.endswith(".ipynb"):
        try:
            return [Piece(cell.place, cell.source) for cell in cells_of(content, file)]
        except SubmissionError:
            return []
    return [Piece(file, content.decode("utf-8", "replace"))] if file.endswith(".py") else []


def winnowed(tokens: Sequence[Token], piece: int) -> list[Print]:
    """Return the smallest hash in each window of hashes, the last one of equals, each once.

    Two texts with `RUN` + `WINDOW` - 1 equal tokens have a fingerprint in common. Parts shorter
    than `RUN` are not found. `piece` is the number of the text in the program. Source: Schleimer,
    Wilkerson, Aiken: Winnowing: Local Algorithms for Document Fingerprinting. SIGMOD 2003.
    """
    kinds = [token.kind for token in tokens]
    texts = ("\0".join(kinds[i : i + RUN]) for i in range(len(kinds) - RUN + 1))
    hashes = [blake2b(one.encode(errors="replace"), digest_size=8).digest() for one in texts]
    kept: list[int] = []
    for start in range(max(len(hashes) - WINDOW + 1, min(len(hashes), 1))):
        window = hashes[start : start + WINDOW]
        smallest = min(window)
        at = start + len(window) - 1 - window[::-1].index(smallest)
        if not kept or kept[-1] != at:
            kept.append(at)
    return [Print(hashes[i], piece, tokens[i].line, tokens[i + RUN - 1].line) for i in kept]


_LEAST_SHARE = 0.3
_LEAST_PRINTS, _LEAST_LINES = 8, 6
_MOST_PAIRS, _MOST_PASSAGES, _MOST_LINES = 50, 3, 40
_NEAR = 3  # lines between parts that are one passage
# What more submissions have than that, or than a quarter of them, is how it is done.
_FEW = 10


@dataclass(frozen=True)
class Passage:
    """Lines of a file."""

    file: str
    first_line: int
    last_line: int
    text: str


@dataclass(frozen=True)
class SimilarPair:
    """Two submissions that resemble each other."""

    first: str
    second: str
    #: The part of each program that the other has, too, 0 to 1.
    share_of_first: float
    share_of_second: float
    lines: int  # how many lines of the first that is
    #: The longest parts in common, of the first and of the second.
    passages: tuple[tuple[Passage, Passage], ...]


def similar_pairs(
    programs: Mapping[str, Program], given: Iterable[Program] = ()
) -> list[SimilarPair]:
    """Return the pairs that have most in common, the most similar first, without given text."""
    known = {each.hash for program in given for each in program.prints}
    own = {
        name: [each for each in program.prints if each.hash not in known]
        for name, program in sorted(programs.items())
    }
    owners = _owners(own)
    counts: Counter[tuple[str, str]] = Counter()
    for names in owners.values():
        counts.update(combinations(sorted(names), 2))
    pairs = [
        _pair(names, own, owners, programs)
        for names, count in counts.items()
        if count >= _LEAST_PRINTS
    ]
    similar = [
        pair
        for pair in pairs
        if max(pair.share_of_first, pair.share_of_second) >= _LEAST_SHARE
        and pair.lines >= _LEAST_LINES
    ]
    similar.sort(key=lambda p: (-max(p.share_of_first, p.share_of_second), p.first, p.second))
    return similar[:_MOST_PAIRS]


def _owners(own: Mapping[str, Sequence[Print]]) -> dict[bytes, set[str]]:
    owners: defaultdict[bytes, set[str]] = defaultdict(set)
    for name, prints in own.items():
        for each in prints:
            owners[each.hash].add(name)
    many = max(_FEW, len(own) // 4)
    return {key: names for key, names in owners.items() if 2 <= len(names) <= many}


def _pair(
    names: tuple[str, str],
    own: Mapping[str, Sequence[Print]],
    owners: Mapping[bytes, set[str]],
    programs: Mapping[str, Program],
) -> SimilarPair:
    first, second = names
    common = [
        [each for each in own[name] if set(names) <= owners.get(each.hash, set())] for name in names
    ]
    places = {each.hash: each for each in reversed(common[1])}
    parts = _joined([(each, places[each.hash]) for each in common[0]])
    parts.sort(key=lambda part: (part[0].first_line - part[0].last_line, part))
    lines = {
        (each.piece, line)
        for each in common[0]
        for line in range(each.first_line, each.last_line + 1)
    }
    return SimilarPair(
        first,
        second,
        len(common[0]) / len(own[first]),
        len(common[1]) / len(own[second]),
        len(lines),
        tuple(
            (_passage(programs[first], left), _passage(programs[second], right))
            for left, right in parts[:_MOST_PASSAGES]
        ),
    )


def _joined(matches: Sequence[tuple[Print, Print]]) -> list[tuple[Print, Print]]:
    joined: list[tuple[Print, Print]] = []
    for left, right in matches:
        if joined and _follows(joined[-1][0], left) and _follows(joined[-1][1], right):
            joined[-1] = (_both(joined[-1][0], left), _both(joined[-1][1], right))
        else:
            joined.append((left, right))
    return joined


def _follows(before: Print, after: Print) -> bool:
    return (
        before.piece == after.piece
        and before.first_line <= after.first_line <= before.last_line + _NEAR
    )


def _both(before: Print, after: Print) -> Print:
    return before._replace(last_line=max(before.last_line, after.last_line))


def _passage(program: Program, part: Print) -> Passage:
    piece = program.pieces[part.piece]
    shown = piece.text.split("\n")[part.first_line - 1 : part.last_line]
    more = ["..."] if len(shown) > _MOST_LINES else []
    text = "\n".join([*shown[:_MOST_LINES], *more])
    return Passage(piece.file, part.first_line, part.last_line, text)
