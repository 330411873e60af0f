"""The file of a trace: an archive of arrays with a text about the run, without pickle."""

from __future__ import annotations

import codecs
import io
import json
import math
import os
import re
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.files import open_file, packed_arrays, write_whole
from robsim.base.files.reading import parse_json
from robsim.base.text import cut, listed, one_line, quoted, said_by
from robsim.trace.columns import check_group_name
from robsim.trace.run_info import RunInfo

FORMAT = "robsim trace 1"
_INFO = "info"
_OF_OLD_NUMPY = "allow_pickle"  # numpy below 2.2 stored the keyword as an array
_MOST_INFO = 2**24  # bytes, 4 for a character, in any file
_MOST_INFO_PACKED = 8  # bytes for each byte of the file: a scenario has pictures
_MOST_SIGNS = 400_000  # of JSON; a scenario has at most a quarter
_MOST_SMALL = 2**28  # bytes that any file may contain
_PART = 2**20  # bytes that are unpacked at a time

T = TypeVar("T")

Content = tuple[Mapping[str, Floats], RunInfo, int]
"""Groups of columns, facts about the whole run, number of the first step."""


def write_trace(path: Path, content: Content) -> None:
    write_whole(path, pack_trace(content))


def pack_trace(content: Content) -> bytes:
    groups, run_info, first_step = content
    info = {
        "format": FORMAT,
        "groups": list(groups),
        "first_step": first_step,
        **run_info.as_record(),
    }
    members = {_INFO: np.array(json.dumps(info)), **groups}
    archive = packed_arrays(members)
    if sum(array.nbytes for array in members.values()) > _most_unpacked(len(archive)):
        # A robot at rest has highly compressible columns, which the size limit would refuse.
        archive = packed_arrays(members, compress=False)
    return archive


def _most_unpacked(size: int) -> int:
    """Return the largest content (bytes) of a file of this size: traces compress only so far."""
    return _MOST_SMALL + 10 * size


def read_trace(path: Path, build: Callable[[Content], T]) -> T:
    """Return the result of `build` for a file of `write_trace`; else raise a ValueError."""
    with open_file(path) as file:
        return _built(file, one_line(path), build)


def unpack_trace(packed: bytes, name: str, build: Callable[[Content], T]) -> T:
    """Return the result of `build` for bytes of `pack_trace`; else a ValueError has the name."""
    return _built(io.BytesIO(packed), name, build)


def _built(file: BinaryIO, name: str, build: Callable[[Content], T]) -> T:
    try:
        if not zipfile.is_zipfile(file):
            raise ValueError("it is not an archive of arrays")
        with zipfile.ZipFile(file) as archive:
            return build(_content_of(archive, size=file.seek(0, os.SEEK_END)))
    except _BROKEN as error:
        message = cut(error) if type(error) is ValueError else said_by(error)
        raise ValueError(f"{name} is not a robsim trace, or is damaged: {message}") from error


# The errors of reading a broken archive, in addition to our own checks.
_BROKEN = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OSError,
    MemoryError,
    RuntimeError,
    OverflowError,
    zipfile.BadZipFile,
    zlib.error,
    SyntaxError,
    tokenize.TokenError,
)


def _content_of(archive: zipfile.ZipFile, size: int) -> Content:
    """Return the content of a trace; sizes are checked before anything is unpacked."""
    info = _read_info(archive, size)
    if missing := {"format", "first_step", "groups", "area"} - info.keys():
        raise ValueError(f"its info has no {min(missing)}")
    if info.pop("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT!r}")
    first_step = info.pop("first_step")
    names = info.pop("groups")
    if not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise ValueError("its groups have no names")
    for name in names:
        check_group_name(name)
    stored = [member.removesuffix(".npy") for member in archive.NameToInfo]
    if sorted(names) != sorted(set(stored) - {_INFO, _OF_OLD_NUMPY}):
        raise ValueError(f"its groups must match the list in its info, got {listed(stored)}")
    _check_sizes(archive, names, size)
    groups = {name: _read_array(archive, name) for name in names}
    for name in ("area", "callbacks", "changed", "marker_colors"):
        if not isinstance(value := info.get(name, []), list):
            raise ValueError(f"its {name} must be a list, got {quoted(value)}")
        info[name] = tuple(value)
    return groups, RunInfo(**info), first_step


def _read_info(archive: zipfile.ZipFile, size: int) -> dict[str, Any]:
    if f"{_INFO}.npy" not in archive.NameToInfo:
        raise ValueError("it has no info")
    dtype, shape, unpacked = _header(archive, _INFO)
    if dtype.kind != "U" or shape != ():
        raise ValueError(f"its info is {dtype} of shape {quoted(shape)}, not a text")
    if unpacked > (most := max(_MOST_INFO, _MOST_INFO_PACKED * size)):
        raise ValueError(f"its info has more than {most >> 20} MB")
    info = parse_json(_text_of(archive, dtype), _MOST_SIGNS)
    if not isinstance(info, dict):
        raise ValueError("its info is not a table of values")
    return info


def _text_of(archive: zipfile.ZipFile, dtype: np.dtype[Any]) -> str:
    """Return the text of the info, never with all of its 4 bytes a character in memory.

    numpy itself makes a broken str of a number that is no code point.
    """
    order = dtype.newbyteorder("<") == dtype
    decoder = codecs.getincrementaldecoder("utf-32-le" if order else "utf-32-be")()
    with archive.open(f"{_INFO}.npy") as member:
        np.lib.format.read_magic(member)
        np.lib.format.read_array_header_1_0(member)
        parts = iter(lambda: member.read(_PART), b"")
        return "".join([decoder.decode(part) for part in parts]).rstrip("\0")


def _check_sizes(archive: zipfile.ZipFile, names: list[str], size: int) -> None:
    """Raise a ValueError unless the headers have the same number of rows, and not too many."""
    total, lengths = 0, {}
    for name in names:
        dtype, shape, bytes_ = _header(archive, name)
        if dtype != np.float64 or len(shape) != 2:
            raise ValueError(f"{name} is {dtype} of shape {quoted(shape)}")
        lengths[name] = shape[0]
        total += bytes_
    if len(set(lengths.values())) > 1:
        rows = listed(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"its groups have different numbers of rows: {rows}")
    if total > _most_unpacked(size):
        raise ValueError(
            f"a file of {size / 2**20:.1f} MB must have at most {_most_unpacked(size) >> 20} MB of "
            f"uncompressed data, but it declares {total >> 20} MB"
        )


_HEADER = re.compile(
    rb"{'descr': '([<>|]\w+)', 'fortran_order': (?:Fals|Tru)e, 'shape': \(([\d, ]*)\), } *\n"
)


def _header(archive: zipfile.ZipFile, name: str) -> tuple[np.dtype[Any], tuple[int, ...], int]:
    """Return type, shape and size (bytes) of an array without reading the array."""
    member = archive.NameToInfo[f"{name}.npy"]
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} has a compression that traces do not use")
    with archive.open(member) as file:
        if np.lib.format.read_magic(file) != (1, 0):
            raise ValueError(f"{name} is an array of another format version")
        header = _HEADER.fullmatch(file.read(int.from_bytes(file.read(2), "little")))
        if not header:  # numpy itself would try Python's and Python 2's grammar, with warnings
            raise ValueError(f"{name} has no valid numpy header")
        dtype, shape = np.dtype(header[1].decode()), tuple(map(int, re.findall(rb"\d+", header[2])))
        size = math.prod(shape) * dtype.itemsize
        if dtype.hasobject or size != member.file_size - file.tell():
            raise ValueError(f"{name} does not have the size in its header")
    return dtype, shape, size


def _read_array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    with archive.open(f"{name}.npy") as member:
        array: NDArray[Any] = np.lib.format.read_array(member, allow_pickle=False)
    return array
