"""One codec of TOML files: each key of a table is described once, for reading and writing."""

from __future__ import annotations

import base64
import datetime
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from os import PathLike
from typing import Any

import numpy as np

from robsim.base.checks import check_choice, check_text
from robsim.base.files.reading import MOST_TOML, as_path, parse_toml, read_text
from robsim.base.spelling import check_names
from robsim.base.text import cut, one_line, quoted

Read = Callable[[str, Any], Any]
_WRONG = (TypeError, ValueError, OverflowError)
_LONGEST_LINE = 1000  # characters, among which a key is looked for


class WrongTable(ValueError):
    """An error in a table of a file: a sentence, the path there (lists count from 1), and the key.

    The key is the sentence's first word by default.
    """

    def __init__(self, sentence: str, path: tuple[str, ...] = (), key: str = "") -> None:
        super().__init__(f"[{cut('.'.join(path))}] {sentence}" if path else sentence)
        self.sentence, self.path = sentence, path
        self.key = key or sentence.partition(" ")[0]


@contextmanager
def within(*path: str) -> Iterator[None]:
    """Let an error inside the context speak of a table."""
    try:
        yield
    except WrongTable as error:
        raise WrongTable(error.sentence, path + error.path, error.key) from error
    except _WRONG as error:
        raise WrongTable(str(error), path) from error


def read_table(
    text: str,
    read: Callable[[dict[str, Any]], Any],
    source: object,
    most: int = MOST_TOML,
    parse: Callable[[str, int], Any] = parse_toml,
) -> Any:
    """Return the result of `read` for the table of a text with a limited number of bytes.

    A ValueError names the source, the line of the key, table and key.
    """
    try:
        return read(parse(text, most))
    except _WRONG as error:
        wrong = error if isinstance(error, WrongTable) else WrongTable(str(error))
        line = _line_of(text, (*wrong.path, wrong.key))
        place = f"{one_line(source)}, line {line}" if line else one_line(source)
        raise ValueError(f"{place}: {one_line(error)}") from error


def load_table(
    path: str | PathLike[str],
    read: Callable[[dict[str, Any]], Any] = dict,
    what: str = "",
    most: int = MOST_TOML,
) -> Any:
    """Read a file, as `read_table` reads its text.

    Errors start with `what`, the kind of the file, such as ``"colour file "``.
    """
    file = as_path(path)
    return read_table(read_text(file, most), read, f"{what}{file}", most)


def _line_of(text: str, path: tuple[str, ...]) -> int:
    """Return the line of a key, or of the closest table above it with a line; 0 = no line."""
    found, depth = 0, 0
    table: tuple[str, ...] = ()
    counts: dict[tuple[str, ...], int] = {}
    for number, line in enumerate(text.split("\n"), 1):
        head = line[:_LONGEST_LINE].partition("#")[0].strip()
        if head.startswith("[") and head.endswith("]") and "," not in head:
            place = table = _parts(head.strip("[]"))
            if head.startswith("[["):
                counts[table] = counts.get(table, 0) + 1
                place = table = (*table, str(counts[table]))
        elif "=" in head:
            place = (*table, *_parts(head.partition("=")[0]))
        else:
            continue
        if len(place) > depth and place == path[: len(place)]:
            found, depth = number, len(place)
    return found


def _parts(key: str) -> tuple[str, ...]:
    return tuple(part.strip(" \t\"'") for part in key.split("."))


# --- tables


def plain(value: Any) -> Any:
    """Return a value in the types of TOML, its numbers to the last bit."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, (tuple, list)) else value


def anything(name: str, value: Any) -> Any:
    """Return a value unchecked: its owner checks it."""
    return value


def together(**values: Any) -> dict[str, Any]:
    """Return the values of a table unchanged."""
    return values


@dataclass(frozen=True)
class Entry:
    """A key of a table: how its value is read and written."""

    unit: str = ""  # the comment behind the value
    read: Read = anything  # takes the name, for messages, and the value in the file
    write: Callable[[Any], Any] = plain  # returns what TOML has
    each: Entry | Table | None = None  # of each item


@dataclass(frozen=True)
class Table:
    """A table of a file, for a value; also the entry of a table in another one."""

    make: Callable[..., Any]  # takes the values of the keys, by their names
    keys: Mapping[str, Row]  # in the order of the file
    said: str = ""  # the comment above the keys
    needed: tuple[str, ...] = ()  # beside the parameters of `make` without a default
    parts: Callable[[Any], Any] = lambda value: (value,)  # returns objects with the values
    ignores_others: bool = False
    unit = ""

    @cached_property
    def _entries(self) -> dict[str, Entry | Table]:
        return {key: _entry(row) for key, row in self.keys.items()}

    @cached_property
    def _needed(self) -> tuple[str, ...]:
        needed = {
            name
            for name, one in signature(self.make).parameters.items()
            if one.default is one.empty and one.kind is not one.VAR_KEYWORD
        }
        return tuple(key for key in self.keys if key in {*needed, *self.needed})

    def read(self, name: str, value: Any) -> Any:
        """Return the value of a table."""
        table = as_table(name, value, f" with {', '.join(self.keys)}")
        given = {key: one for key, one in table.items() if key in self.keys}
        for key in () if self.ignores_others else table:
            check_key(key, self.keys)
        for key in self._needed:
            if key not in table:
                raise ValueError(f"{key} is missing")
        return self.make(**{key: read_key(key, self._entries[key], given[key]) for key in given})

    def write(self, value: Any, kind: str = "") -> Any:
        """Return the table of a value, without None and NaN; a kind becomes its first key."""
        if (parts := self.parts(value)) is None:
            return None
        written: dict[str, Any] = {"kind": kind} if kind else {}
        for key, entry in self._entries.items():
            held = _held(parts, key)
            given = None if held is None else entry.write(held)
            if given is not None and given == given:  # NaN = not known
                written[key] = item(given, entry.unit)
        return table_of(written, self.said)


#: What describes a key; a text is the unit of a value that its owner checks, a function reads one.
Row = Entry | Table | str | Read


def _entry(row: Row) -> Entry | Table:
    if isinstance(row, (Entry, Table)):
        return row
    return Entry(row) if isinstance(row, str) else Entry("", row)


def _held(parts: Iterable[Any], key: str) -> Any:
    """Return a value of the first part that has it, by key or attribute; None = none has."""
    for part in parts:
        if isinstance(part, Mapping):
            if key in part:
                return part[key]
        elif hasattr(part, key):
            return getattr(part, key)
    return None


def table_of(written: Mapping[str, Any], said: str = "") -> Any:
    """Return a table of values as `item` returns them; one of tables alone has no line."""
    import tomlkit  # it costs milliseconds

    is_table = {key: isinstance(one, dict) for key, one in written.items()}
    table = tomlkit.table(is_super_table=bool(written) and all(is_table.values()))
    for line in said.splitlines():
        table.add(tomlkit.comment(line))
    # Below a table, a plain value would belong to it.
    for key in sorted(written, key=is_table.__getitem__):
        table.add(key, written[key])
    return table


def item(value: Any, unit: str = "") -> Any:
    """Return a value as text for a file, with a comment; bytes are base64."""
    import tomlkit

    if isinstance(value, bytes):
        lines = base64.encodebytes(value).decode()
        made: Any = tomlkit.string(f"\n{lines}", multiline=True, literal=True)
    else:
        made = tomlkit.item(value)
    return made.comment(unit) if unit else made


def rows(array: Any) -> Any:
    """Return an array as text for a file, a row a line."""
    return item(plain(array)).multiline(True)


def read_key(name: str, entry: Entry | Table, value: Any) -> Any:
    """Return the value of a key; if it is a table, errors name its path."""
    if not isinstance(value, dict):
        return entry.read(name, value)
    with within(name):
        return entry.read(name, value)


def as_table(name: str, value: Any, hint: str = "") -> dict[str, Any]:
    """Return a table of a file; else raise TypeError, with a hint."""
    table: dict[str, Any] = of_type(name, value, f"a table{hint}", dict)
    return table


def check_key(key: str, known: Iterable[str], what: str = "there is no key") -> None:
    """Raise an error for an unknown key, with the one that was meant."""
    check_names(what, [key], known, lambda sentence: WrongTable(sentence, key=key))


def named(row: Row, hint: str = "", said: str = "") -> Entry:
    """Return the entry of a table of rows by any names, below a comment: of a dict."""
    entry = _entry(row)

    def read(name: str, value: Any) -> dict[str, Any]:
        table = as_table(name, value, hint)
        return {key: read_key(key, entry, one) for key, one in table.items()}

    def write(values: Mapping[Any, Any]) -> Any:
        return table_of({str(key): item(entry.write(one)) for key, one in values.items()}, said)

    return Entry("", read, write, each=entry)


def listed(entry: Table) -> Entry:
    """Return the entry of a list of tables, each below a line ``[[name]]``."""

    def read(name: str, value: Any) -> list[Any]:
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise TypeError(
                f"{name} must be a list of tables, each below a line [[{name}]], got "
                f"{in_words(value)}"
            )
        with within(name):
            return [read_key(str(number), entry, one) for number, one in enumerate(value, 1)]

    return Entry("", read, each=entry)


def kind_of(table: dict[str, Any], kinds: tuple[str, ...]) -> str:
    """Remove and return the key ``kind`` of a table; with only one kind it may be missing."""
    if "kind" not in table and len(kinds) > 1:
        raise ValueError(f"kind is missing; expected one of {', '.join(map(repr, kinds))}")
    return check_choice("kind", table.pop("kind", kinds[0]), kinds)


# --- kinds of values


def in_words(value: Any) -> str:
    """Return a wrong value in the words of TOML."""
    if isinstance(value, (datetime.date, datetime.time)):
        return f"the time {value.isoformat()}"
    if isinstance(value, dict):
        return "a table"
    return str(value).lower() if isinstance(value, bool) else quoted(value)


def of_type(name: str, value: Any, expected: str, *types: type) -> Any:
    """Return a value of TOML if it has one of these types; in TOML, true is no number."""
    if type(value) in types:
        return value
    raise TypeError(f"{name} must be {expected}, got {in_words(value)}")


def flag(name: str, value: Any) -> bool:
    return bool(of_type(name, value, "true or false", bool))


def date(name: str, value: Any) -> datetime.datetime:
    if not isinstance(value, datetime.datetime) or value.tzinfo is None:
        raise TypeError(f"{name} must be a time with a time zone, got {in_words(value)}")
    return value


def names(name: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise TypeError(f'{name} must be a list of names, such as ["red"], got {in_words(value)}')
    return tuple(value)


def base64_bytes(name: str, value: Any) -> bytes:
    try:
        return base64.b64decode("".join(check_text(name, value).split()), validate=True)
    except ValueError as error:
        raise ValueError(f"{name} must be base64: {error}") from error


def base64_pairs(name: str, value: Any) -> Any:
    """Return pairs of float64, as `pairs_base64` writes them."""
    data = base64_bytes(name, value)
    if len(data) % 16:
        raise ValueError(f"{name} must have 16 bytes per step (two float64), got {len(data)} bytes")
    return np.frombuffer(data, "<f8").reshape(-1, 2)


def pairs_base64(values: Any) -> bytes:
    return np.asarray(values, "<f8").tobytes()


def check_format(table: Mapping[str, Any], expected: int) -> None:
    """Raise ValueError unless the key ``format`` of a file is this one."""
    given = table.get("format")
    if type(given) is not int or given != expected:
        raise WrongTable(
            f"format must be {expected}, got {in_words(given)}: this is another kind of file, or "
            "was written by another version of robsim"
        )
