"""The protocol of motors: lines, limits, firmware."""

import binascii
import locale
import random
import re
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import motor_lines
from motor_lines import drive_line, line, stop_line
from motor_lines import example as page_example
from robsim._core import parse_line, to_line
from robsim.lab import Limits

with_compiler = pytest.mark.skipif(not shutil.which("c++"), reason="needs a C++ compiler")


# --- lines


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


# --- limits


volts = st.floats(-20, 20)
inputs = st.tuples(volts, volts)
limits = st.floats(0.01, 30)


@given(inputs, limits)
def test_a_voltage_limit_keeps_the_curve(u, limit):
    result = Limits(voltage=limit).applied(u, (0, 0), 0.1)
    assert np.abs(result).max() <= limit
    if np.abs(u).max() <= limit:
        assert result.tolist() == list(u)
    else:
        assert np.abs(result).max() == pytest.approx(limit)
        assert result[0] * u[1] == pytest.approx(result[1] * u[0], abs=1e-9)
        assert (result * u >= 0).all()


@given(inputs, inputs, limits, st.floats(0, 2))
def test_a_slew_rate_limits_the_change_and_keeps_its_direction(u, before, limit, dt):
    result = Limits(slew_rate=limit).applied(u, before, dt)
    change, wanted = result - before, np.subtract(u, before)
    if u == (0, 0):
        assert result.tolist() == [0, 0]
        return
    assert np.abs(change).max() <= limit * dt + 1e-12
    assert change[0] * wanted[1] == pytest.approx(change[1] * wanted[0], abs=1e-9)
    if np.abs(wanted).max() <= limit * dt:
        assert result.tolist() == list(u)


@given(inputs, limits, limits, st.floats(0.01, 2))
def test_both_limits_hold_on_the_way_to_any_input(u, voltage, slew_rate, dt):
    both = Limits(voltage=voltage, slew_rate=slew_rate)
    before = np.zeros(2)
    for _ in range(20):
        after = both.applied(u, before, dt)
        assert np.abs(after).max() <= voltage
        assert np.abs(after - before).max() <= slew_rate * dt + 1e-12
        before = after


def test_stopping_is_never_slowed_down():
    assert Limits(voltage=1, slew_rate=0.01).applied((0, 0), (9, -9), 0.0).tolist() == [0, 0]


def test_what_is_out_of_range_is_refused():
    for name in ("voltage", "slew_rate"):
        for value in (0, -1, float("nan")):
            with pytest.raises(ValueError, match=name):
                Limits(**{name: value})
    with pytest.raises(ValueError, match="dt"):
        Limits(slew_rate=1).applied((1, 1), (0, 0), -1)


# --- firmware


# Of stdin: a time (ms) and the bytes that come then, in hexadecimal. To stdout: what is driven.
BOARD = r"""
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

uint32_t now = 0;
uint32_t millis() { return now; }
void drive(float u1, float u2) { std::printf("%u %.4f %.4f\n", now, u1, u2); }
struct {
  std::string bytes;
  void begin(long) {}
  int available() { return bytes.size(); }
  int read() { int c = bytes[0]; bytes.erase(0, 1); return c; }
} Serial;
FIRMWARE
int main() {
  setup();
  unsigned time;
  char hex[100000];
  while (std::scanf("%u %99999s", &time, hex) == 2) {
    for (; now < time; ++now) loop();
    for (char* c = hex; *c != '-' && *c; c += 2) {
      char digits[3] = {c[0], c[1], 0};
      Serial.bytes += static_cast<char>(std::strtoul(digits, nullptr, 16));
    }
    loop();
  }
}
"""


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    folder = tmp_path_factory.mktemp("firmware")
    (folder / "board.cpp").write_text(BOARD.replace("FIRMWARE", page_example("cpp")))
    command = ["c++", "-std=c++17", "-w", "-o", folder / "board", folder / "board.cpp"]
    subprocess.run(command, check=True)

    def run(*said):
        text = "".join(f"{t} {text.hex() or '-'}\n" for t, text in said)
        done = subprocess.run(
            [folder / "board"], input=text, capture_output=True, text=True, check=True
        )
        return [tuple(map(float, row.split())) for row in done.stdout.splitlines()]

    return run


@pytest.mark.slow
@with_compiler
def test_it_obeys_and_stops_by_itself(driven):
    assert driven((10, drive_line(7, 0.5, -0.25, 300)), (1000, b"")) == [
        (10, 0.5, -0.25),
        (310, 0, 0),
    ]
    assert driven((10, drive_line(7, ttl=300)), (200, drive_line(8, ttl=300)), (900, b"")) == [
        (10, 1, 2),
        (200, 1, 2),
        (500, 0, 0),
    ]
    assert driven((10, drive_line(7)), (20, stop_line(8))) == [(10, 1, 2), (20, 0, 0)]


@pytest.mark.slow
@with_compiler
def test_it_ignores_what_it_must(driven):
    old = [(11, drive_line(7, 3)), (12, drive_line(6, 3)), (13, drive_line(7 + 32768, 3))]
    damaged = [
        (20, drive_line(8, 3)[:-3] + b"00\n"),
        (21, b"x" * 300 + drive_line(9, 3)),
        (22, b"\n\n*\n\0\0\n*1234\n"),
        (23, line("a 12")),
        (24, bytes(range(256)) + b"\n"),
    ]
    after = (30, drive_line(8, 4)[:-1] + b"\r\n")
    assert driven((10, drive_line(7)), *old, *damaged, after) == [(10, 1, 2), (30, 4, 2)]


@pytest.mark.slow
@with_compiler
def test_random_bytes_do_it_no_harm(driven):
    random.seed(1)
    noise = [(k, random.randbytes(random.randrange(1, 200))) for k in range(300)]
    assert driven(*noise, (400, b"\n" + drive_line(1))) == [(400, 1, 2)]
