"""Arrays on the wire: what can be sent comes as it was, and no bytes of a stranger are believed."""

import struct

import numpy as np
import pytest

from robsim.teach.grading.arrays import as_array, as_arrays, from_message, to_parts


def message(*arrays):
    return b"".join(bytes(part) for part in to_parts(as_arrays("array", arrays)))


def test_arrays_come_as_they_were_sent():
    sent = {
        "f8": [
            0.5,
            [1.0, np.nan, -np.inf],
            np.arange(6, dtype=">f4").reshape(2, 3).T,
            [],
            [[]] * 3,
        ],
        "i8": [7, [[1, 2], [3, 4]], np.array([2**63 - 1], np.uint64)],
        "u1": [True, np.arange(24, dtype=np.uint8).reshape(2, 3, 4)],
    }
    for dtype, values in sent.items():
        came = from_message(message(*values))
        assert len(came) == len(values)
        for one, value in zip(came, values, strict=True):
            np.testing.assert_array_equal(one, np.asarray(value))
            assert (one.dtype, one.shape) == (np.dtype(dtype), np.shape(value))
            assert one.flags.writeable
            assert one.flags.owndata
    assert from_message(message()) == []


def test_what_is_no_array_of_real_numbers_is_refused():
    assert as_array("x", np.zeros((1, 1, 1))).ndim == 3
    for value, error in (
        ("text", TypeError),
        (1j, TypeError),
        ([[1, 2], [3]], ValueError),
        (np.zeros((1, 1, 1, 1)), ValueError),
        (np.array([2**63], np.uint64), ValueError),
    ):
        with pytest.raises(error, match=r"\bx\b"):
            as_array("x", value)


def test_too_much_is_refused():
    assert len(as_arrays("argument", [0] * 16)) == 16
    with pytest.raises(ValueError, match="16 arguments, got 17"):
        as_arrays("argument", [0] * 17)
    whole = np.broadcast_to(np.uint8(0), 64 << 20)
    as_arrays("argument", [whole])
    with pytest.raises(ValueError, match=r"arguments .* 64 MiB"):
        as_arrays("argument", [whole, [1]])


def test_bytes_that_are_none_are_refused():
    for body in (
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
    ):
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
