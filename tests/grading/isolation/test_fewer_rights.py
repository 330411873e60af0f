"""A grader with fewer rights: that of a container, that of a user who is not root."""

import json
import os
import subprocess
import sys

import pytest

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        sys.platform != "linux" or os.geteuid() != 0, reason="gives rights of root away"
    ),
]

# The rights that root has in a container as Docker starts it, by their numbers.
CONTAINER = (0, 1, 3, 4, 5, 6, 7, 8, 10, 13, 18, 27, 29, 31)

CHECK = """
import struct, sys
from robsim.teach.isolation._layers import calls
keep = set(map(int, sys.argv[1:]))
for number in range(41):
    if number not in keep:
        calls.prctl(calls.PR_CAPBSET_DROP, number)
mask = sum(1 << number for number in keep)
words = (mask & 0xFFFFFFFF, mask & 0xFFFFFFFF, 0, mask >> 32, mask >> 32, 0)
calls._libc.capset(struct.pack("<Ii", 0x20080522, 0), struct.pack("<6I", *words))
assert not calls.has_capability(21)
from robsim.teach import check_isolation
import json
report = check_isolation()
print(json.dumps([report.layers, report.attempts, report.closed]))
"""


@pytest.mark.parametrize("rights", [CONTAINER, ()], ids=["a container", "root without rights"])
def test_what_holds_without_the_right_to_administer(rights):
    command = [sys.executable, "-c", CHECK, *map(str, rights)]
    run = subprocess.run(command, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    layers, attempts, closed = json.loads(run.stdout.splitlines()[-1])
    held = {name for name, holds, _ in layers if holds}
    assert not held & {"own network", "own process numbers"}
    if not rights:
        assert "user" not in held
    if {"files", "system calls"} <= held:
        assert all(closed.values())
        assert all(refused for refused, _ in attempts.values()), attempts
