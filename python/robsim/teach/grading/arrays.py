"""Arrays on the wire: numbers and shapes, and nothing else."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.text import quoted

#: Maximum size (bytes) and number of all arrays of a message.
MOST_BYTES, MOST_ARRAYS = 64 << 20, 16
_KINDS = (np.dtype("<f8"), np.dtype("<i8"), np.dtype("u1"))  # by their codes
_MOST_AXES = 3
_ENTRY = struct.Struct("<BB3Q")  # kind, axes, shape
_COUNT = struct.Struct("<I")
#: Most bytes of a message of arrays.
MOST_MESSAGE = MOST_BYTES + _COUNT.size + MOST_ARRAYS * _ENTRY.size


def as_array(what: str, value: Any) -> NDArray[Any]:
    """Return a value as an array for a message: float64, int64 or uint8, of at most 3 axes.

    Raise TypeError or ValueError with the name `what`.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        raise ValueError(f"{what} must be an array of numbers, got {_shown(value)}") from None
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{what} must be an array of real numbers, got {_shown(value)}")
    if array.ndim > _MOST_AXES:
        raise ValueError(f"{what} must have at most {_MOST_AXES} axes, got {array.ndim}")
    if array.dtype == np.uint64 and array.size and array.max() >= 1 << 63:
        raise ValueError(f"{what} must have integers below 2**63, got {array.max()}")
    return np.ascontiguousarray(array, _kind_of(array)).reshape(array.shape)


def _shown(value: Any) -> str:
    return f"one of {value.dtype}" if isinstance(value, np.ndarray) else quoted(value)


def _kind_of(array: NDArray[Any]) -> np.dtype[Any]:
    if array.dtype.kind == "f":
        return _KINDS[0]
    return _KINDS[2] if array.dtype.kind == "b" or array.dtype == np.uint8 else _KINDS[1]


def as_arrays(what: str, values: Sequence[Any]) -> list[NDArray[Any]]:
    """Return values as arrays for one message; raise the errors of `as_array`, or ValueError."""
    if len(values) > MOST_ARRAYS:
        raise ValueError(f"at most {MOST_ARRAYS} {what}s are allowed, got {len(values)}")
    one = len(values) == 1
    names = [f"the {what}" if one else f"{what} {i}" for i in range(1, len(values) + 1)]
    arrays = [as_array(name, value) for name, value in zip(names, values, strict=True)]
    if (size := sum(array.nbytes for array in arrays)) > MOST_BYTES:
        raise ValueError(
            f"the {what}s must have at most {MOST_BYTES >> 20} MiB in all, got {size >> 20} MiB"
        )
    return arrays


def to_parts(arrays: Iterable[NDArray[Any]]) -> list[bytes | memoryview]:
    arrays = list(arrays)
    heads = [_COUNT.pack(len(arrays))]
    for array in arrays:
        shape = (*array.shape, 0, 0, 0)[:_MOST_AXES]
        heads.append(_ENTRY.pack(_KINDS.index(array.dtype), array.ndim, *shape))
    return [b"".join(heads), *(array.reshape(-1).view(np.uint8).data for array in arrays)]


def from_message(message: bytes | memoryview) -> list[NDArray[Any]]:
    """Return copies of the arrays of an untrusted message; raise ValueError if it is invalid."""
    count = _COUNT.unpack_from(message)[0] if len(message) >= _COUNT.size else -1
    place = _COUNT.size + max(count, 0) * _ENTRY.size
    if not 0 <= count <= MOST_ARRAYS or len(message) < place:
        raise ValueError("arrays with missing heads")
    arrays = []
    for i in range(count):
        kind, axes, *shape = _ENTRY.unpack_from(message, _COUNT.size + i * _ENTRY.size)
        if kind >= len(_KINDS) or axes > _MOST_AXES:
            raise ValueError("an array of an unknown type")
        size = math.prod(shape[:axes])
        if size * _KINDS[kind].itemsize > len(message) - place:
            raise ValueError("an array that is longer than its message")
        array = np.frombuffer(message, _KINDS[kind], size, place)
        try:
            arrays.append(array.reshape(shape[:axes]).copy())
        except (ValueError, OverflowError):  # an axis of 0 beside one of 2**60
            raise ValueError("an array of an invalid shape") from None
        place += array.nbytes
    if place != len(message):
        raise ValueError("arrays that do not fill their message")
    return arrays
