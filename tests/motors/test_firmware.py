"""The firmware that PROTOCOL.md shows, compiled for this machine, obeys as our receiver does."""

import random
import shutil
import subprocess

import pytest

from motor_lines import drive_line, example, line, stop_line

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("c++"), reason="needs a C++ compiler"),
]

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
    (folder / "board.cpp").write_text(BOARD.replace("FIRMWARE", example("cpp")))
    command = ["c++", "-std=c++17", "-w", "-o", folder / "board", folder / "board.cpp"]
    subprocess.run(command, check=True)

    def run(*said):
        text = "".join(f"{t} {text.hex() or '-'}\n" for t, text in said)
        done = subprocess.run(
            [folder / "board"], input=text, capture_output=True, text=True, check=True
        )
        return [tuple(map(float, row.split())) for row in done.stdout.splitlines()]

    return run


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


def test_random_bytes_do_it_no_harm(driven):
    random.seed(1)
    noise = [(k, random.randbytes(random.randrange(1, 200))) for k in range(300)]
    assert driven(*noise, (400, b"\n" + drive_line(1))) == [(400, 1, 2)]
