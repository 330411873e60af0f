"""Arrays on the wire: what can be sent comes as it was, and no bytes of a stranger are believed."""

import struct

import numpy as np
import pytest

from robsim.grading._calls.arrays import as_array, as_arrays, from_message, to_parts


def message(*arrays):
    return b"".join(bytes(part) for part in to_parts(as_arrays("array", arrays)))


@pytest.mark.parametrize(
    ("value", "dtype"),
    [
        (0.5, "f8"),
        (7, "i8"),
        (True, "u1"),
        ([[1, 2], [3, 4]], "i8"),
        ([1.0, np.nan, -np.inf], "f8"),
        (np.arange(24, dtype=np.uint8).reshape(2, 3, 4), "u1"),
        (np.arange(6, dtype=">f4").reshape(2, 3).T, "f8"),
        (np.array([2**63 - 1], np.uint64), "i8"),
        (np.zeros((0, 5)), "f8"),
        ([], "f8"),
    ],
)
def test_an_array_comes_as_it_was_sent(value, dtype):
    (came,) = from_message(message(value))
    np.testing.assert_array_equal(came, np.asarray(value))
    assert (came.dtype, came.shape) == (np.dtype(dtype), np.shape(value))
    assert came.flags.writeable
    assert came.flags.owndata


def test_many_arrays_keep_their_order():
    came = from_message(message(*([i] * i for i in range(5))))
    assert [array.tolist() for array in came] == [[i] * i for i in range(5)]
    assert from_message(message()) == []


@pytest.mark.parametrize(
    ("value", "error", "told"),
    [
        ("text", TypeError, "x must be an array of real numbers, got 'text'"),
        (None, TypeError, "x must be an array of real numbers, got None"),
        (1j, TypeError, "real numbers"),
        ([[1, 2], [3]], ValueError, "x must be an array of numbers"),
        (np.zeros((1, 1, 1, 1)), ValueError, "at most 3 axes, got 4"),
        (np.array([2**63], np.uint64), ValueError, "integers below"),
    ],
)
def test_what_is_no_array_is_named(value, error, told):
    with pytest.raises(error, match=told):
        as_array("x", value)


def test_too_much_is_refused():
    with pytest.raises(ValueError, match="there may be 16 arguments, got 17"):
        as_arrays("argument", [0] * 17)
    with pytest.raises(ValueError, match="the arguments may have 64 MiB in all, got 95 MiB"):
        as_arrays("argument", [np.zeros(10**8, np.uint8)])


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"abc",
        struct.pack("<I", 1),
        struct.pack("<I", 17) + bytes(17 * 26),
        struct.pack("<I", 2**32 - 1),
        struct.pack("<IBB3Q", 1, 3, 0, 0, 0, 0),
        struct.pack("<IBB3Q", 1, 2, 4, 0, 0, 0),
        struct.pack("<IBB3Q", 1, 2, 1, 5, 0, 0) + bytes(4),
        struct.pack("<IBB3Q", 1, 2, 1, 5, 0, 0) + bytes(6),
        struct.pack("<IBB3Q", 1, 0, 3, 2**63, 2**63, 2**63) + bytes(8),
        struct.pack("<IBB3Q", 1, 0, 3, 2**63, 2**63, 0),
        struct.pack("<IBB3Q", 1, 0, 3, 0, 2**62, 2**62),
    ],
)
def test_bytes_that_are_none_are_refused(body):
    with pytest.raises(ValueError, match=r"^(an array|arrays)"):
        from_message(body)


def test_random_bytes_are_taken_or_refused(rng):
    good = message([1.5, 2.5], [[3]], np.arange(4, dtype=np.uint8))
    taken = 0
    for _ in range(2000):
        body = bytearray(good)
        for _ in range(rng.integers(1, 4)):
            body[rng.integers(len(body))] ^= 1 << rng.integers(8)
        try:
            arrays = from_message(bytes(body[: len(body) - (rng.random() < 0.1)]))
        except ValueError:
            continue
        taken += 1
        assert sum(array.nbytes for array in arrays) <= len(good)
    assert 100 < taken < 1900
