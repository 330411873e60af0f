"""Random harm: whatever is handed in, it is read, or refused in words; it never runs."""

import io
import json
import pickle
import random
import tracemalloc
import zipfile

import pytest
from hypothesis import given

from fuzzing import LONGEST_MESSAGE, SEEDS, fuzzed
from robsim.teach import SubmissionError
from submissions import BOTH, PLAIN, read_submission

pytestmark = [pytest.mark.fuzz, pytest.mark.filterwarnings("ignore:Duplicate name")]

MOST_MEMORY = 100 * 2**20  # bytes, for some kB that are handed in


def attempt(path, counts):
    """Read a submission; it may be refused, and nothing else."""
    refusal = None
    tracemalloc.start()
    try:
        found = read_submission(path, BOTH)
    except SubmissionError as error:
        refusal = str(error)
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < MOST_MEMORY
    if refusal is None:
        counts["read"] += 1
        assert pickle.loads(pickle.dumps(found)) == found
        assert found.slots
    else:
        counts["refused"] += 1
        assert refusal.isprintable(), ascii(refusal)
        assert 0 < len(refusal) < LONGEST_MESSAGE


def mutated(rng, content):
    """Some bytes changed, taken out, doubled or put elsewhere."""
    content = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 5))):
        at, end = sorted(rng.choices(range(len(content) + 1), k=2))
        end = min(end, at + rng.choice((1, 2, 4, 50)))
        start = rng.randrange(len(content) + 1)
        odd = rng.choice((b"\xff", b"\0", b"../", b"PK\1\2", b"\x7f"))
        new = (rng.randbytes(end - at), b"", content[at:end] * 2, odd, content[start : start + 30])
        content[at:end] = rng.choice(new)
    return bytes(content)


NAMES = [
    *("control.py", "measure.py", "a/control.py", "helper.py", "../x", "a\\b", "CONTROL.PY", "con"),
    *("x.ipynb", "\u202e", "a" * 141, "/abs", "__MACOSX/x", "\xe9", "e\u0301", ".hidden", "a//b"),
    *("./c", "z.zip", ""),
]
CONTENTS = [PLAIN, "", "x" * 5000, "def (", "\0", "import helper"]


def random_zip(rng):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in ["control.py", *rng.sample(NAMES, rng.choice((0, 1, 1, 2, 5)))]:
            info = zipfile.ZipInfo("x")
            info.filename = name
            info.compress_type = rng.choice((0, 8, 8, 8))
            kinds = (0, 0o100644, 0o100644, 0o100644, 0o100644, 0o120777, 0o010644)
            info.external_attr = rng.choice(kinds) << 16
            archive.writestr(info, rng.choice(CONTENTS))
    return buffer.getvalue()


STATEMENTS = [
    PLAIN,
    "@sim.control\ndef drive(step):\n    return GAIN, K[0]",
    "sim.control = drive",
    "GAIN = 3",
    "K = [1, 2]\nK[0] = GAIN",
    "control = lambda step: (GAIN, f(step))",
    "def f(x):\n    return g(x)",
    "def g(x):\n    return f(x)",
    "sim = robsim.Simulation(control=drive, seed=1)",
    "trace = sim.run(10)",
    "GAIN = trace.u[0]",
    "%matplotlib inline",
    "!ls 'x",
    "%%bash\nrm",
    "x = !ls",
    "f?",
    "import numpy as np",
    "from math import *",
    "for i in range(3):\n    K.append(i)",
    "while 1: pass",
    "class C:\n    a = GAIN",
    "measure = C()",
    "sim.measure = C()",
    "@sim.measure\n@other\nclass M(C): ...",
    "GAIN += 1",
    "(a, b), *c = K",
    "with open('x') as h: GAIN = h",
    "try:\n    import q\nexcept ImportError:\n    q = None",
    "del GAIN",
    "global GAIN",
    "return 3",
    "await x",
    "[y := 1 for z in K]",
    "lambda: (yield)",
    "match K:\n    case [p]: GAIN = p",
    "control: int = f",
    "from __future__ import annotations",
    "from __future__ import nothing",
    "x = (",
    "    indented",
    "\xe9 = 1",
    "'''",
    "nonlocal a",
    "Simulation(control=lambda s: i)",
    "control = control",
    "sim.control = sim.measure = f",
    "async def control(s): ...",
    "sim.control = True",
    "type(sim).control = f",
    "if a: control = f",
    "exec('x')",
    "# robsim:\ncontrol = f",
    "# robsim-skip\n",
    "",
]


def random_notebook(rng):
    cells = []
    for _ in range(rng.randrange(1, 9)):
        source = "\n".join(rng.sample(STATEMENTS, rng.randrange(1, 4)))
        tags = rng.choice(([], [], [], ["robsim"], ["robsim-skip"], [3], "robsim"))
        kind = rng.choice(("code", "code", "code", "markdown", 3))
        as_list = source.splitlines(True)
        cells.append({"cell_type": kind, "metadata": rng.choice(({"tags": tags}, {}, None)),
                      "source": rng.choice((source, source, as_list)), "outputs": []})  # fmt: skip
    return json.dumps({"nbformat": 4, "metadata": {}, "cells": cells}).encode()


def random_file(rng):
    return "\n".join([PLAIN, *rng.sample(STATEMENTS, 2)]).encode()


ROUNDS = 10


@pytest.mark.long
@pytest.mark.parametrize(
    ("make", "suffix", "is_often_read"),
    [
        (random_zip, ".zip", True),
        (lambda rng: mutated(rng, random_zip(rng)), ".zip", False),
        (random_notebook, ".ipynb", True),
        (lambda rng: mutated(rng, random_notebook(rng)), ".ipynb", False),
        (lambda rng: mutated(rng, random_file(rng)), ".py", False),
    ],
    ids=["zips", "mutated zips", "notebooks", "mutated notebooks", "files"],
)
def test_random_submissions(tmp_path_factory, make, suffix, is_often_read):
    folder = tmp_path_factory.mktemp("random")
    counts = {"read": 0, "refused": 0}

    @fuzzed
    @given(SEEDS)
    def read_some(seed):
        rng = random.Random(seed)
        for _ in range(ROUNDS):
            path = folder / f"s001{suffix}"
            path.write_bytes(make(rng))
            attempt(path, counts)

    read_some()
    assert counts["refused"]
    assert counts["read"] or not is_often_read, "what is always refused tests nothing"
