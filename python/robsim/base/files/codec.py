"""One codec of TOML files: tables whose keys are described once, to be read and to be written."""

from __future__ import annotations

import base64
import datetime
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim.base.checks import as_float_array, check_choice, check_float, check_int
from robsim.base.files.reading import MOST_TOML, as_path, parse_toml, read_text
from robsim.base.spelling import check_names
from robsim.base.text import cut, one_line, quoted

if TYPE_CHECKING:
    from tomlkit.items import Item

Read = Callable[[str, Any], Any]
_WRONG = (TypeError, ValueError, OverflowError)
_MOST_ROWS = 10_000  # of an array that is not in base64, such as a polygon
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


@contextmanager
def telling(source: object, text: str) -> Iterator[None]:
    """Let a ValueError inside the context name a file, and the line of the key in its text."""
    try:
        yield
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
    """Read the table of a file of at most so many bytes; return the result of `read`.

    A ValueError names file, line, table and key. It starts with `what`, the kind of the file, such
    as ``"colour file "``.
    """
    file = as_path(path)
    text = read_text(file, most)
    with telling(f"{what}{file}", text):
        return read(parse_toml(text, most))


def _line_of(text: str, path: tuple[str, ...]) -> int:
    """Return the line of a key, or of the table next above it that has one; 0 = none has."""
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


@dataclass(frozen=True)
class Entry:
    """A key of a table: how its value is read and written."""

    read: Read  # takes the name, for messages, and the value in the file
    unit: str = ""  # the comment behind the value
    write: Callable[[Any], Any] = plain  # returns what TOML has
    is_needed: bool = False


@dataclass(frozen=True)
class Table:
    """A table of a file, for a value."""

    make: Callable[..., Any]  # takes the values of the keys, by their names
    keys: dict[str, Entry]  # in the order of the file
    said: str = ""  # the comment above the keys
    ignores_others: bool = False

    def read(self, name: str, value: Any) -> Any:
        """Return the value of a table."""
        return self.make(**self.values(name, value))

    def values(self, name: str, value: Any) -> dict[str, Any]:
        """Return the values of the keys of a table, by their names."""
        table = as_table(name, value)
        if self.ignores_others:
            table = {key: one for key, one in table.items() if key in self.keys}
        for key in table:
            check_key(key, self.keys)
        for key, one in self.keys.items():
            if one.is_needed and key not in table:
                raise ValueError(f"{key} is missing")
        return {key: read_key(key, self.keys[key].read, given) for key, given in table.items()}

    def write(self, value: Any, kind: str = "") -> Any:
        """Return the table of a value, without None and NaN; a kind becomes its first key."""
        import tomlkit  # it costs milliseconds

        table = tomlkit.table()
        if self.said:
            table.add(tomlkit.comment(self.said))
        if kind:
            table.add("kind", kind)
        for name, key in self.keys.items():
            held = value.get(name) if isinstance(value, Mapping) else getattr(value, name)
            given = None if held is None else key.write(held)
            if given is not None and given == given:  # NaN = not known
                table.add(name, item(given, key.unit))
        return table


def item(value: Any, unit: str = "") -> Item:
    """Return a value as it is written, with a comment; bytes are base64."""
    import tomlkit

    if isinstance(value, bytes):
        lines = base64.encodebytes(value).decode()
        made: Item = tomlkit.string(f"\n{lines}", multiline=True, literal=True)
    else:
        made = tomlkit.item(value)
    return made.comment(unit) if unit else made


def read_key(name: str, read: Read, value: Any) -> Any:
    """Return the value of a key; if it is a table, errors name its path."""
    if not isinstance(value, dict):
        return read(name, value)
    with within(name):
        return read(name, value)


def as_table(name: str, value: Any, hint: str = "") -> dict[str, Any]:
    """Return a table of a file; else raise TypeError, with a hint."""
    table: dict[str, Any] = of_type(name, value, f"a table{hint}", dict)
    return table


def check_key(key: str, known: Iterable[str], what: str = "there is no key") -> None:
    """Raise an error for an unknown key, with the one that was meant."""
    check_names(what, [key], known, lambda sentence: WrongTable(sentence, key=key))


def by_name(name: str, value: Any, read: Read, hint: str = "") -> dict[str, Any]:
    """Read each of the tables in a table; return the results by their names."""
    tables = as_table(name, value, hint)
    return {key: read_key(key, read, table) for key, table in tables.items()}


def super_table(tables: Mapping[str, Any]) -> Any:
    """Return a table that has only tables, and no line in the file."""
    import tomlkit

    table = tomlkit.table(is_super_table=True)
    for name, one in tables.items():
        table.add(name, one)
    return table


def listed_tables(name: str, value: Any, read: Read) -> list[Any]:
    """Read each table of a list, ``[[name]]``; return the results."""
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        raise TypeError(
            f"{name} must be tables, each below a line [[{name}]], got {in_words(value)}"
        )
    made = []
    for number, one in enumerate(value, 1):
        with within(name, str(number)):
            made.append(read(name, one))
    return made


def kind_of(table: dict[str, Any], kinds: tuple[str, ...]) -> str:
    """Take the key ``kind`` out of a table; where there is one kind alone, it may be missing."""
    if "kind" not in table and len(kinds) > 1:
        raise ValueError(f"kind is missing, one of {', '.join(map(repr, kinds))}")
    return check_choice("kind", text("kind", table.pop("kind", kinds[0])), kinds)


# --- kinds of values


def in_words(value: Any) -> str:
    """Return what came, in the words of TOML."""
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


def anything(name: str, value: Any) -> Any:
    """Return what came: its owner checks it."""
    return value


def text(name: str, value: Any) -> str:
    return str(of_type(name, value, "a text", str))


def flag(name: str, value: Any) -> bool:
    return bool(of_type(name, value, "true or false", bool))


def number(name: str, value: Any) -> float:
    return check_float(name, of_type(name, value, "a number", int, float))


def up_to(most: float) -> Read:
    """Return a reader of numbers from 0 to the most."""
    return lambda name, value: check_float(
        name, of_type(name, value, "a number", int, float), minimum=0, maximum=most
    )


def count(name: str, value: Any) -> int:
    whole = of_type(name, value, "a whole number", int)
    return check_int(name, whole, minimum=0, maximum=2**31 - 1)


def choice(*choices: str) -> Read:
    """Return a reader of one of some texts."""
    return lambda name, value: check_choice(name, value, choices)


def date(name: str, value: Any) -> datetime.datetime:
    if not isinstance(value, datetime.datetime) or value.tzinfo is None:
        raise TypeError(f"{name} must be a time with its zone, got {in_words(value)}")
    return value


def names(name: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise TypeError(f'{name} must be a list of names, such as ["red"], got {in_words(value)}')
    return tuple(value)


def numbers(name: str, value: Any) -> Any:
    """Return a number or an array that its owner checks."""
    if isinstance(value, list) and len(value) > _MOST_ROWS:
        raise ValueError(f"{name} must have at most {_MOST_ROWS} rows, got {len(value)}")
    return of_type(name, value, "numbers", list, int, float)


def array(*shape: int) -> Read:
    """Return a reader of finite numbers of a shape."""

    def read(name: str, value: Any) -> Any:
        size = " x ".join(map(str, shape))
        expected = f"{name} must be {size} finite numbers, got {in_words(value)}"
        try:
            found = as_float_array(name, value)
        except TypeError:
            raise TypeError(expected) from None
        if found.shape != shape or not np.isfinite(found).all():
            raise ValueError(expected)
        return found

    return read


def base64_bytes(name: str, value: Any) -> bytes:
    try:
        return base64.b64decode("".join(text(name, value).split()), validate=True)
    except ValueError as error:
        raise ValueError(f"{name} must be base64: {error}") from error


def base64_pairs(name: str, value: Any) -> Any:
    """Return pairs of float64, as `pairs_base64` writes them."""
    data = base64_bytes(name, value)
    if len(data) % 16:
        raise ValueError(f"{name} must be pairs of float64, 16 bytes a step, got {len(data)} bytes")
    return np.frombuffer(data, "<f8").reshape(-1, 2)


def pairs_base64(values: Any) -> bytes:
    return np.asarray(values, "<f8").tobytes()


def check_format(table: Mapping[str, Any], *readable: int, hint: str = "") -> None:
    """Raise ValueError unless the key ``format`` of a file is one of these."""
    given = table.get("format")
    if type(given) is not int or given not in readable:
        expected = " or ".join(map(str, readable))
        hint = hint or "another one is of a newer robsim"
        raise WrongTable(f"format must be {expected}, got {in_words(given)}: {hint}")
