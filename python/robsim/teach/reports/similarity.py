"""Equal and similar programs, and their common parts."""

from __future__ import annotations

import json
import keyword
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, islice, pairwise, product
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.notebook.cells import cells_of

# Never fails: any other character is a token alone. Left out: imports, comments, texts alone on
# their lines, commands of notebooks, line continuations, last commas.
_STRING = r"""(?:(?i:[rbuft]{0,3})
    (?:'''(?:[^'\\]|\\.|'(?!''))*+(?:'''|\Z)
      |\"""(?:[^"\\]|\\.|"(?!""))*+(?:\"""|\Z)
      |'(?:[^'\\\n]|\\.)*+(?:'|$|\Z)
      |"(?:[^"\\\n]|\\.)*+(?:"|$|\Z)))"""
_TOKEN = re.compile(
    rf"""
    (?P<none>^[ \t]*+(?:import|from)[ \t](?:[^\n(;]*+\([^)]*+\)?|[^\n;]*+)
      |\#[^\n]*+|^[ \t]*+(?:[%!][^\n]*+|{_STRING}[ \t\r]*+$)|[\\;]|,(?=\s*+[])}}]))
  | (?P<text>{_STRING})
  | (?P<number>\.?\d[\w.]*(?:(?<=[eE])[+-]\d+)?)
  | (?P<name>[^\W\d]\w*)
  | (?P<sign>\S)
    """,
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_KEYWORDS = frozenset(keyword.kwlist)


def tokens_of(source: str) -> Iterator[tuple[str, int, bool]]:
    """Yield the kind of each token, its first line, from 1, and whether it starts that line.

    All names are equal, except attributes of other modules and values, such as ``inv`` in
    ``np.linalg.inv``; so are numbers and texts. Comments and imports are left out.
    """
    line, counted = 1, 0
    before = ("", "")
    for match in _TOKEN.finditer(source):
        start, what, text = match.start(), match.lastgroup, match.group()
        line += source.count("\n", counted, start)
        counted = start
        if what == "none":
            continue
        is_own = what == "name" and (before[1] != "." or before[0] == "self")
        is_one = what in ("text", "number") or (is_own and text not in _KEYWORDS)
        yield f"a {what}" if is_one else text, line, start == 0 or source[start - 1] == "\n"
        before = (before[1], text)


RUN = 16  # tokens that are compared as a unit, some two lines
_MOST_TOKENS = 100_000  # of a submission; the rest is not compared


class Place(NamedTuple):
    """Lines of a piece, by its number in the program."""

    piece: int
    first_line: int
    last_line: int

    def reaches(self, after: Place) -> bool:
        is_near = self.first_line <= after.first_line <= self.last_line + _NEAR
        return is_near and self.piece == after.piece

    def until(self, after: Place) -> Place:
        return Place(*self[:2], max(self.last_line, after.last_line))


@dataclass(frozen=True)
class Program:
    """A submission: files and cells, each with its name and text."""

    pieces: tuple[tuple[str, str], ...]

    @cached_property
    def read(self) -> tuple[dict[int, bool], list[tuple[int, Place]], bool]:
        """Hashes: of statements at the top, and which are definitions; of runs, and where.

        The last value is true for a program that was cut.
        """
        statements, runs = {}, []
        left = _MOST_TOKENS
        for number, (_, text) in enumerate(self.pieces):
            tokens = list(islice(tokens_of(text), left))
            left -= len(tokens)
            kinds = [kind for kind, _, _ in tokens]
            tops = [i for i, (_, _, is_top) in enumerate(tokens) if is_top]
            for start, end in pairwise([*tops, len(tokens)]):
                what = hash(tuple(kinds[start:end]))
                statements[what] = kinds[start] in ("def", "class", "async")
            for end in range(min(RUN, len(tokens) or RUN), len(tokens) + 1):
                start = max(end - RUN, 0)
                place = Place(number, tokens[start][1], tokens[end - 1][1])
                runs.append((hash(tuple(kinds[start:end])), place))
        return statements, runs, not left

    def lines(self, runs: Collection[int]) -> set[tuple[int, int]]:
        """Return piece and number of each line of some runs."""
        places = {place for run, place in self.read[1] if run in runs}
        return {(at, line) for at, first, last in places for line in range(first, last + 1)}


def program_of(sources: Mapping[str, bytes]) -> Program:
    """Return the Python files and notebooks among files, by their names."""
    pieces: list[tuple[str, str]] = []
    for file, content in sorted(sources.items()):
        if file.endswith(".py"):
            pieces.append((file, content.decode("utf-8-sig", "replace")))
        elif file.endswith(".ipynb"):
            with suppress(SubmissionError):
                pieces += [(cell.place, cell.source) for cell in cells_of(content, file)]
    return Program(tuple(pieces))


_LEAST_SHARE, _LEAST_RUNS = 0.45, 24  # these are some five lines
_MOST_PAIRS, _MOST_PASSAGES, _MOST_LINES = 50, 3, 40
_NEAR = 3  # lines between parts of one passage
# Text is common if more programs than these, and more than a quarter of all, have it.
_FEW_STUDENTS, _FEW_OTHERS = 10, 50


EARLIER_YEAR = "earlier: "  # prefix of a submission of an earlier year


@dataclass(frozen=True)
class Group:
    """Programs with the same functions and classes, except names, numbers, comments, layout."""

    names: Sequence[str]  # students, then other programs
    lines: int  # of the first, without given text


@dataclass(frozen=True)
class Passage:
    """Lines of a file."""

    file: str
    first_line: int
    last_line: int
    text: str


@dataclass(frozen=True)
class SimilarPair:
    """Two similar programs, each the first of its group."""

    first: str  # a student
    second: str
    #: The part of each program that the other has, too, 0 to 1, without given and common text.
    share_of_first: float
    share_of_second: float
    lines: int  # number of these lines in the first
    common_lines: int  # lines of the first that were left out, because many have them
    #: The longest common parts, in the first and in the second.
    passages: Sequence[tuple[Passage, Passage]]


@dataclass(frozen=True)
class Comparison:
    """Copies, similar pairs, and common text of a class."""

    groups: Sequence[Group]  # the largest first
    pairs: Sequence[SimilarPair]  # the most similar first
    common_lines: int  # lines that pairs leave out, because many students have them
    mostly_common: Sequence[str]  # students who have more such lines than others
    too_long: Sequence[str]

    @property
    def alike(self) -> list[Sequence[str]]:
        """The names of each group and each pair."""
        pairs = ((pair.first, pair.second) for pair in self.pairs)
        return [*(group.names for group in self.groups), *pairs]

    def renamed(self, pseudonym: Callable[[str], str]) -> Comparison:
        """Return a copy with other names of students, and without text."""

        def name(old: str) -> str:
            year = EARLIER_YEAR if old.startswith(EARLIER_YEAR) else ""
            is_solution = "/" in old and not year
            return old if is_solution else year + pseudonym(old.removeprefix(year))

        def in_order(names: Iterable[str]) -> list[str]:
            return sorted(map(name, names), key=lambda one: (":" in one or "/" in one, one))

        return Comparison(
            [replace(one, names=in_order(one.names)) for one in self.groups],
            [
                replace(one, first=name(one.first), second=name(one.second), passages=())
                for one in self.pairs
            ],
            self.common_lines,
            in_order(self.mostly_common),
            in_order(self.too_long),
        )


def read_comparison(file: Path) -> Comparison | None:
    """Return the comparison in a file, or None without a file."""
    try:
        data = json.loads(file.read_bytes())
        groups = [Group(**one) for one in data["groups"]]
        for pair in data["pairs"]:
            pair["passages"] = [[Passage(**one) for one in both] for both in pair["passages"]]
        pairs = [SimilarPair(**pair) for pair in data["pairs"]]
        return Comparison(**data | {"groups": groups, "pairs": pairs})
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None


def compared(
    programs: Mapping[str, Program],
    given: Iterable[Program] = (),
    others: Mapping[str, Program] = MappingProxyType({}),
) -> Comparison:
    """Compare the programs of students with each other and with others, without given text.

    Pairs have the first programs of groups, so many copies do not become common text. Of a
    student's pairs with others only the most similar one is kept.
    """
    every = dict(sorted(programs.items())) | dict(others)
    known = [program.read for program in given]
    groups = _groups(every, {each for statements, *_ in known for each in statements})
    given_runs = {run for _, runs, _ in known for run, _ in runs}
    own = {name: {run for run, _ in every[name].read[1]} - given_runs for name in groups}
    common, counts = _common(own, programs)
    left = {name: runs - common for name, runs in own.items()}
    lines = {name: every[name].lines(left[name]) for name in own if name in programs}
    left_out = {name: len(every[name].lines(common) - lines[name]) for name in lines}
    shares = {
        names: (count / len(left[names[0]]), count / len(left[names[1]]))
        for names, count in counts.items()
        if count >= _LEAST_RUNS
    }
    copied = {name for name, names in groups.items() if names[-1] in others}
    pairs: list[SimilarPair] = []
    for first, second in sorted(shares, key=lambda names: (-max(shares[names]), names)):
        both, runs = shares[first, second], left[first] & left[second]
        if max(both) < _LEAST_SHARE or len(pairs) == _MOST_PAIRS:
            break
        if second in programs or first not in copied:
            copied |= {first} if second in others else set()
            passages = _passages(every[first], every[second], runs)
            count = len(every[first].lines(runs))
            pairs.append(SimilarPair(first, second, *both, count, left_out[first], passages))
    return Comparison(
        [
            Group(names, len(every[name].lines(own[name])))
            for name, names in sorted(groups.items(), key=lambda one: (-len(one[1]), one))
            if len(names) > 1 and name in programs
        ],
        pairs,
        sum(left_out.values()),
        [name for name, count in left_out.items() if count > len(lines[name])],
        [name for name, program in sorted(programs.items()) if program.read[2]],
    )


def _groups(programs: Mapping[str, Program], given: Collection[int]) -> dict[str, list[str]]:
    """Return the names of equal programs by the first one, without programs of only given text."""
    groups: defaultdict[tuple[int, ...], list[str]] = defaultdict(list)
    for name, program in programs.items():
        own = {key: defines for key, defines in program.read[0].items() if key not in given}
        groups[tuple(sorted(filter(own.get, own)) or sorted(own))].append(name)
    return {names[0]: names for key, names in groups.items() if key}


def _common(
    own: Mapping[str, set[int]], students: Collection[str]
) -> tuple[set[int], Counter[tuple[str, str]]]:
    """Return the runs in many programs, and for each pair the number of other shared runs."""
    owners: defaultdict[int, tuple[list[str], list[str]]] = defaultdict(lambda: ([], []))
    for name, runs in own.items():
        for run in runs:
            owners[run][name not in students].append(name)
    count = sum(name in students for name in own)
    many, many_others = max(_FEW_STUDENTS, count // 4), max(_FEW_OTHERS, (len(own) - count) // 4)
    common, counts = set(), Counter[tuple[str, str]]()
    for run, (mine, theirs) in owners.items():
        if len(mine) > many or len(theirs) > many_others:
            common.add(run)
        else:
            counts.update(combinations(mine, 2))
            counts.update(product(mine, theirs))
    return common, counts


def _passages(
    first: Program, second: Program, runs: Collection[int]
) -> list[tuple[Passage, Passage]]:
    """Return the longest common parts."""
    places = dict(reversed(second.read[1]))
    parts: list[tuple[Place, Place]] = []
    for left, right in ((place, places[run]) for run, place in first.read[1] if run in runs):
        if parts and parts[-1][0].reaches(left) and parts[-1][1].reaches(right):
            before, beside = parts.pop()
            left, right = before.until(left), beside.until(right)
        parts.append((left, right))
    parts.sort(key=lambda part: (part[0].first_line - part[0].last_line, part))
    longest = parts[:_MOST_PASSAGES]
    return [(_passage(first, left), _passage(second, right)) for left, right in longest]


def _passage(program: Program, place: Place) -> Passage:
    file, text = program.pieces[place.piece]
    shown = text.split("\n")[place.first_line - 1 : place.last_line]
    more = ["..."] if len(shown) > _MOST_LINES else []
    return Passage(file, *place[1:], "\n".join([*shown[:_MOST_LINES], *more]))
