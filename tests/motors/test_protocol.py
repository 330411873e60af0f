"""Lines of the protocol: written, read back, damaged."""

import binascii
import locale
import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import motor_lines
from robsim._core import parse_line, to_line

FORM = re.compile(
    rb"(?:u ([0-9]{1,5}) (-?[0-9]{1,3}\.[0-9]{4}) (-?[0-9]{1,3}\.[0-9]{4}) ([0-9]{1,5}) "
    rb"|s ([0-9]{1,5}) ([0-9]{1,5}) |a ([0-9]{1,5}) )\*([0-9A-F]{4})\r?"
)

numbers = st.integers(0, 65535)
voltages = st.floats(-999.9999, 999.9999)
times = st.integers(1, 60000)


def read_by_the_page(line):
    """What PROTOCOL.md says of a line."""
    said = FORM.fullmatch(line)
    if not said or len(line) > 47:
        return None
    if binascii.crc_hqx(line[: line.rindex(b"*")], 0) != int(said[8], 16):
        return None
    kind = line[:1].decode()
    number = int(said[1] or said[5] or said[7])
    ttl = int(said[4] or said[6] or 0)
    if number > 65535 or (kind != "a" and not 1 <= ttl <= 60000):
        return None
    return kind, number, float(said[2] or 0), float(said[3] or 0), ttl


@given(numbers, voltages, voltages, times)
@example(0, -0.0, 0.00004, 1)
@example(65535, -999.9999, 999.9999, 60000)
def test_an_input_is_read_back_to_a_tenth_of_a_millivolt(number, u1, u2, ttl):
    line = to_line("u", number, (u1, u2), ttl)
    assert len(line) <= 48
    assert line.isascii()
    assert line.endswith(b"\n")
    kind, *rest = parse_line(line[:-1])
    assert (kind, *rest) == read_by_the_page(line[:-1])
    assert [rest[0], rest[3]] == [number, ttl]
    assert abs(rest[1] - u1) <= 0.5001e-4
    assert abs(rest[2] - u2) <= 0.5001e-4
    again = to_line("u", number, rest[1:3], ttl)
    assert again == line


@given(numbers, times)
def test_stops_and_answers_are_read_back(number, ttl):
    assert parse_line(to_line("s", number, (1, 2), ttl)[:-1]) == ("s", number, 0, 0, ttl)
    assert parse_line(to_line("a", number, (1, 2), ttl)[:-1]) == ("a", number, 0, 0, 0)


def test_the_lines_of_the_page_are_right():
    lines = re.findall(r"^    ([usa] \d+ .*\*\w{4})", motor_lines.PAGE.read_text(), re.MULTILINE)
    assert [parse_line(line.encode()) for line in lines] == [
        ("u", 1234, 0.5, -0.25, 300),
        ("s", 1235, 0, 0, 300),
        ("a", 1235, 0, 0, 0),
    ]


words = st.one_of(
    st.sampled_from([b"u", b"s", b"a", b"*", b"", b"-0.0000", b"1.00000", b"1000.0000", b"1,0000"]),
    st.sampled_from([b"65536", b"0", b"60001", b"-1", b"+1", b" 1", b"1e3", b"nan", b"0x1", b"\0"]),
    st.integers(0, 99999).map(lambda n: b"%d" % n),
    st.floats(-1001, 1001).map(lambda u: b"%.4f" % u),
    st.binary(max_size=6),
)


@given(st.lists(words, max_size=7))
def test_any_words_with_the_right_checksum_are_read_as_the_page_says(chosen):
    text = b"".join(word + b" " for word in chosen)
    line = text + b"*%04X" % binascii.crc_hqx(text, 0)
    assert parse_line(line) == read_by_the_page(line)


@given(st.binary(max_size=60))
def test_any_bytes_are_read_as_the_page_says(line):
    assert parse_line(line) == read_by_the_page(line)


@pytest.mark.long
@given(numbers, voltages, voltages, times, st.data())
def test_up_to_three_bits_that_change_are_found(number, u1, u2, ttl, data):
    line = bytearray(to_line("u", number, (u1, u2), ttl)[:-1])
    bits = st.integers(0, 8 * line.index(b"*") - 1)  # the checksum's own text is another code
    for bit in data.draw(st.sets(bits, min_size=1, max_size=3)):
        line[bit // 8] ^= 1 << bit % 8
    assert parse_line(bytes(line)) is None


def test_a_locale_with_a_decimal_comma_changes_nothing():
    before = locale.setlocale(locale.LC_ALL)
    expected = to_line("u", 1, (1234.5 / 1000, -0.5), 300)
    try:
        for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "nl_NL.UTF-8"):
            try:
                locale.setlocale(locale.LC_ALL, name)
            except locale.Error:
                continue
            assert to_line("u", 1, (1234.5 / 1000, -0.5), 300) == expected
            assert parse_line(expected[:-1]) == ("u", 1, 1.2345, -0.5, 300)
    finally:
        locale.setlocale(locale.LC_ALL, before)


def test_what_fits_into_no_line_is_refused():
    for u1 in (1000, -1000, 1e300):
        with pytest.raises(ValueError, match=r"u1 .*999\.9999"):
            to_line("u", 1, (u1, 0), 300)
    with pytest.raises(ValueError, match="finite"):
        to_line("u", 1, (np.nan, 0), 300)
