"""Pairs of submissions that have much of their programs in common, and which part."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from robsim.teach.reports.similarity.winnowing import Print, Program

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
    """Two submissions that resemble each other.

    Attributes
    ----------
    first, second : str
        Their names.
    share_of_first, share_of_second : float
        The part of each program that the other has, too, 0 to 1.
    lines : int
        How many lines of the first that is.
    passages : tuple of (Passage, Passage)
        The longest parts in common, of the first and of the second.
    """

    first: str
    second: str
    share_of_first: float
    share_of_second: float
    lines: int
    passages: tuple[tuple[Passage, Passage], ...]


def similar_pairs(
    programs: Mapping[str, Program], given: Iterable[Program] = ()
) -> list[SimilarPair]:
    """Return the pairs that have most in common, the most similar first.

    Parameters
    ----------
    programs : mapping of str to Program
        The submissions by name.
    given : iterable of Program
        What all were given: it does not count.
    """
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
    """Return who has each fingerprint, of those that several have, but not many."""
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
    """Return matches that follow each other in both programs as one."""
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
