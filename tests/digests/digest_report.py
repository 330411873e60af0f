"""`compare_digests`: what this machine computes beside what others did."""

from __future__ import annotations

import hashlib
import json
import math
import platform
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from digest_cases import BYTES, DIGITS
from robsim._core import cpu_path
from robsim.base.checks import Floats
from robsim.base.report import Column, Quantity, Report, Row, Table

_EXPECTED = Path(__file__).with_name("expected.json")
_ALL_DIGITS = 17  # of a double: the numbers are equal
_NUMBERS = 12  # that are kept of a case


@dataclass(frozen=True, kw_only=True)
class Digest:
    """What came of one case.

    Attributes
    ----------
    name : str
        The case.
    promised : int or None
        To how many digits it is the same everywhere; None = to the last byte.
    digits : int or None
        To how many it is here; None = to the last byte.
    """

    name: str
    promised: int | None
    digits: int | None

    @property
    def ok(self) -> bool:
        """Whether the promise is kept."""
        if self.digits is None:
            return True
        return self.promised is not None and self.digits >= self.promised


def _in_words(digits: float | None) -> str:
    if digits is None:
        return "bytes"
    return "other" if digits < 0 else f"{digits} digits"


@dataclass(frozen=True, kw_only=True)
class DigestReport(Report):
    """Whether the numbers of this machine are those of others; print it.

    Attributes
    ----------
    digests : tuple of Digest
        One for each case.
    surroundings : str
        Processor, versions and instructions in use.
    """

    digests: tuple[Digest, ...]
    surroundings: str

    @property
    def ok(self) -> bool:
        """Whether all promises are kept."""
        return all(digest.ok for digest in self.digests)

    @property
    def title(self) -> str:
        """What it is."""
        return "The same numbers as elsewhere"

    @property
    def verdict(self) -> str:
        """Whether all promises are kept."""
        return "as promised" if self.ok else "not as promised"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """How many are, and where."""
        kept = sum(digest.ok for digest in self.digests)
        return (
            Quantity("kept", f"as promised, of {len(self.digests)}", kept),
            Quantity("surroundings", "here", self.surroundings),
        )

    @property
    def tables(self) -> list[Table]:
        """The cases."""
        columns = [
            Column("digits", "the same", format=_in_words, missing="bytes"),
            Column("promised", "promised", format=_in_words, missing="bytes"),
            Column("ok", "", format=lambda ok: "" if ok else "differs"),
        ]
        rows = [Row(one.name, [one.digits, one.promised, one.ok]) for one in self.digests]
        return [Table(key="cases", columns=columns, rows=rows, row_title="case")]


def compare_digests() -> DigestReport:
    """Compute small runs of every kind, and compare them with what is expected.

    Worlds, paths, frames, measurements and the recursive estimate are the same to the last byte on
    every machine and with every version of what robsim needs; where linear algebra or numpy's
    random numbers are on the way, results agree to the digits promised.

    Returns
    -------
    DigestReport
        The comparison; print it.

    """
    expected = json.loads(_EXPECTED.read_text())
    return DigestReport(
        digests=(*_bytes_compared(expected["bytes"]), *_digits_compared(expected["digits"])),
        surroundings=_surroundings(),
    )


def _bytes_compared(expected: dict[str, str]) -> Iterator[Digest]:
    for name, arrays in BYTES.items():
        is_same = digest_of(arrays()) == expected.get(name)
        yield Digest(name=name, promised=None, digits=None if is_same else -1)


def _digits_compared(expected: dict[str, list[float]]) -> Iterator[Digest]:
    for name, (promised, numbers) in DIGITS.items():
        digits = digits_of(some_of(numbers()), np.array(expected.get(name, [])))
        yield Digest(name=name, promised=promised, digits=digits)


def digest_of(arrays: Iterable[Any]) -> str:
    """Return a hash of shapes and bytes; every NaN counts as the same."""
    total = hashlib.sha256()
    for values in arrays:
        array = np.asarray(values)
        if array.dtype.kind == "f":
            array = np.where(np.isnan(array), np.nan, array).astype("<f8")
        total.update(str((array.dtype.str, array.shape)).encode())
        total.update(array.tobytes())
    return total.hexdigest()[:20]


def some_of(numbers: Floats) -> Floats:
    """Return some of the numbers, evenly spread."""
    flat = np.asarray(numbers, dtype=np.float64).ravel()
    some: Floats = flat[np.linspace(0, len(flat) - 1, min(len(flat), _NUMBERS)).astype(int)]
    return some


def digits_of(numbers: Floats, expected: Floats) -> int | None:
    """Return to how many digits all numbers agree with the expected ones; None = they are equal."""
    if numbers.shape != expected.shape:
        return -1
    if np.array_equal(numbers, expected):
        return None
    error = np.abs(numbers - expected) / np.maximum(np.abs(expected), 1e-300)
    worst = float(np.max(error))
    return min(math.floor(-math.log10(worst)), _ALL_DIGITS) if 0 < worst < 1 else -1


def _surroundings() -> str:
    return (
        f"{platform.machine()}, {cpu_path()}, Python {platform.python_version()}, "
        f"numpy {np.__version__}, scipy {scipy.__version__}"
    )


def write_expected(file: str | PathLike[str]) -> None:
    """Write what this machine computes as what is expected."""
    values = {
        "bytes": {name: digest_of(arrays()) for name, arrays in BYTES.items()},
        "digits": {name: some_of(numbers()).tolist() for name, (_, numbers) in DIGITS.items()},
    }
    Path(file).write_bytes((json.dumps(values, indent=1) + "\n").encode())
