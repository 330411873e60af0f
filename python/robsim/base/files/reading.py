"""Reading files within limits: paths, content, TOML."""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

from robsim.base.spelling import closest
from robsim.base.text import cut, one_line, quoted

#: Limit of a TOML file without images in it (bytes).
MOST_TOML = 2**20
_MOST_SIGNS = 100_000  # ',', '=', ... outside of images; a second to parse
_MOST_PARTS = 8  # of a dotted key: the time to parse it is their square

_MOST_DIGITS = 4000  # of a number: each takes 124 bytes to parse
_LONG_NUMBER = re.compile(rf"(?<![0-9A-Fa-f_])[0-9A-Fa-f_]{{{_MOST_DIGITS + 1}}}")

_PART = r"""(?>[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')"""
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}[ \t]*\.[ \t]*){{{_MOST_PARTS}}}+{_PART}")


def as_folder(folder: str | PathLike[str]) -> Path:
    return as_path(folder, "folder")


def as_path(path: str | PathLike[str], name: str = "path") -> Path:
    """Return the argument `name` as a Path; else raise TypeError or ValueError."""
    if not isinstance(path, (str, PathLike)):
        raise TypeError(f"{name} must be a path, got {quoted(path)}")
    found = Path(path)
    if "\0" in str(found):
        raise ValueError(f"{name} must be a path without null characters, got {quoted(str(path))}")
    return found


def read_text(path: Path, most: int = MOST_TOML) -> str:
    """Return a file's text of at most so many bytes; else raise a ValueError with its name."""
    content = content_of(path, most + 1)
    if len(content) > most:
        raise ValueError(f"{one_line(path)} must have at most {_size(most)}")
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))  # as PowerShell and Excel write
    try:
        return content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError as error:
        hint = ": save it as CSV UTF-8" if path.suffix.lower() == ".csv" else ""  # Excel's name
        raise ValueError(f"{one_line(path)} is not UTF-8 text{hint}") from error


def _size(count: int) -> str:
    return f"{count >> 20} MB" if count >= 2**20 else f"{count >> 10} kB"


def parse_toml(text: str, most: int = MOST_TOML) -> dict[str, Any]:
    """Parse a TOML text of at most `most` bytes in limited time; else raise ValueError."""
    if len(text.encode(errors="replace")) > most:
        raise ValueError(f"it must have at most {_size(most)}")
    signs = sum(map(text.count, ",=[{.\"'#")) + text.count("\n\n")
    lines = text.count("\n")
    if signs > _MOST_SIGNS or lines > _MOST_SIGNS + len(text) // 50:  # a line of base64 has 76
        raise ValueError(f"it has more than {_MOST_SIGNS} keys, values and comments")
    _check_numbers(text)
    if key := _LONG_KEY.search(text):
        raise ValueError(f"a key must have at most {_MOST_PARTS} parts, got {quoted(key.group())}")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"this is not a TOML file: {cut(error)}") from error


def parse_json(text: str, most: int = _MOST_SIGNS) -> Any:
    """Parse a JSON text of at most `most` values and keys; else raise ValueError."""
    if sum(map(text.count, "[{,:")) > most:
        raise ValueError(f"it has more than {most} keys and values")
    _check_numbers(text)
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    except ValueError as error:
        raise ValueError(f"this is not JSON: {cut(error)}") from None


def _check_numbers(text: str) -> None:
    if number := _LONG_NUMBER.search(text):
        line = quoted(text[: number.end()].rpartition("\n")[2])
        raise ValueError(f"a number must have at most {_MOST_DIGITS} digits, got {line}")


def content_of(path: Path, size: int = -1) -> bytes:
    """Return the first `size` bytes of a file, default all; FileNotFoundError suggests a name."""
    try:
        with open_file(path) as file:
            return file.read(size)
    except FileNotFoundError as error:
        others = path.parent.glob(f"*{path.suffix}") if path.suffix else ()
        meant = closest(path.stem, sorted(other.stem for other in others))
        if meant is None:
            raise FileNotFoundError(error.errno, error.strerror, str(path)) from None
        hint = f"did you mean {meant + path.suffix!r}?"
        raise FileNotFoundError(f"there is no file {one_line(path)}; {hint}") from None


def open_file(path: Path) -> BinaryIO:
    """Open a file for reading; raise ValueError for a pipe or device, which may never end."""
    return open(path, "rb", opener=regular)


def regular(path: str, flags: int) -> int:
    descriptor = os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # no wait for a pipe's writer
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode) or stat.S_ISDIR(mode):  # a folder: Python's own error
        return descriptor
    os.close(descriptor)
    raise ValueError(f"{one_line(path)} must be a regular file, not a pipe or a device")
