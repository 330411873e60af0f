"""Fingerprints of a program: some of the hashes of its runs of tokens, by winnowing."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from robsim.teach.errors import SubmissionError
from robsim.teach.reports.similarity.tokens import Token, tokens_of
from robsim.teach.submissions.notebook.cells import cells_of

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

    Whatever two texts have in common that is at least `RUN` + `WINDOW` - 1 tokens long, they have
    a fingerprint of in common; nothing shorter than `RUN` is found.

    Parameters
    ----------
    tokens : sequence of Token
        The text.
    piece : int
        Its number in the program.

    References
    ----------
    Schleimer, Wilkerson, Aiken: Winnowing: Local Algorithms for Document Fingerprinting.
    SIGMOD 2003.
    """
    kinds = [token.kind for token in tokens]
    hashes = [_hash(kinds[i : i + RUN]) for i in range(len(kinds) - RUN + 1)]
    kept: list[int] = []
    for start in range(max(len(hashes) - WINDOW + 1, min(len(hashes), 1))):
        window = hashes[start : start + WINDOW]
        smallest = min(window)
        at = start + len(window) - 1 - window[::-1].index(smallest)
        if not kept or kept[-1] != at:
            kept.append(at)
    return [Print(hashes[i], piece, tokens[i].line, tokens[i + RUN - 1].line) for i in kept]


def _hash(kinds: Sequence[str]) -> bytes:
    return hashlib.blake2b("\0".join(kinds).encode(errors="replace"), digest_size=8).digest()
