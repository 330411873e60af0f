"""Values with arrays and files, compared and kept; runs of True, and objects with an end."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from hashlib import blake2b
from os import PathLike, fspath, stat
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from robsim.base.closing import Closing as Closing


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a C-contiguous copy of an array, permanently read-only."""
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)


def digest(array: NDArray[Any]) -> bytes:
    """Return 16 bytes that are the same for arrays of the same type, shape and content."""
    content = blake2b(np.ascontiguousarray(array).data, digest_size=16)
    content.update(f"{array.dtype.str}{array.shape}".encode())
    return content.digest()


def runs_of(mask: Any) -> list[tuple[int, int]]:
    """Return start and end of each unbroken run of True in (N,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return [(start, end) for start, end in edges.reshape(-1, 2).tolist()]


@dataclass(frozen=True, eq=False)
class Value:
    """A dataclass with arrays: equal by its content, with a hash, and immutable."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return self is other or self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():  # a pickled array is writable again
            is_array = isinstance(value, np.ndarray)
            object.__setattr__(self, name, frozen(value) if is_array else value)

    @cached_property
    def _content(self) -> tuple[object, ...]:
        """The fields' text, without arrays."""
        values = (getattr(self, field.name) for field in fields(self))
        return tuple(digest(one) if isinstance(one, np.ndarray) else one for one in values)


class Level(NamedTuple):
    """The numbers that a control can set: unit, limits, distance, and the first number."""

    unit: str
    high: float
    step: float
    default: float
    low: float = 0.0


class FileVersion(NamedTuple):
    """A file's path, times and size, which differ after a change: a key for its content."""

    path: str
    mtime_ns: int
    size: int
    inode: int

    @classmethod
    def of(cls, path: str | PathLike[str]) -> FileVersion:
        """Return the present version; raise FileNotFoundError if the file does not exist."""
        status = stat(path)
        return cls(fspath(path), status.st_mtime_ns, status.st_size, status.st_ino)


def packed_arrays(arrays: Mapping[str, NDArray[Any]], *, compress: bool = True) -> bytes:
    """Return arrays as the bytes of a file that `numpy.load` reads."""
    import zipfile  # slow to import, and rarely needed

    compression = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", compression) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    return content.getvalue()
