"""Arrays and files as parts of values, and arrays as files: compared, shared and kept."""

from __future__ import annotations

import io
from collections.abc import Mapping
from hashlib import blake2b
from os import PathLike, fspath, stat
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a C-contiguous copy of an array that nobody can make writable."""
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)


def digest(array: NDArray[Any]) -> bytes:
    """Return 16 bytes that are the same for arrays of the same type, shape and content."""
    content = blake2b(np.ascontiguousarray(array).data, digest_size=16)
    content.update(f"{array.dtype.str}{array.shape}".encode())
    return content.digest()


class FileVersion(NamedTuple):
    """A file and what differs when it has changed: a key for what was read from it."""

    path: str
    mtime_ns: int
    size: int
    inode: int

    @classmethod
    def of(cls, path: str | PathLike[str]) -> FileVersion:
        """Return the present version; raise FileNotFoundError if there is no such file."""
        status = stat(path)
        return cls(fspath(path), status.st_mtime_ns, status.st_size, status.st_ino)


def packed_arrays(arrays: Mapping[str, NDArray[Any]], *, compress: bool = True) -> bytes:
    """Return arrays as the bytes of a file that `numpy.load` reads."""
    import zipfile  # which nobody waits for who writes no arrays

    compression = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", compression) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    return content.getvalue()
