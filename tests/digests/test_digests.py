"""The numbers that robsim promises, computed here and in the surroundings of other machines."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from digest_report import (
    Digest,
    DigestReport,
    compare_digests,
    digest_of,
    digits_of,
    some_of,
)
from robsim._core import cpu_paths

DIGESTS = Path(__file__).parent

SURROUNDINGS = {
    "an old processor, and a C library without AVX2 and FMA": {
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable",
        "OPENBLAS_CORETYPE": "Nehalem",
        "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX X86_V3 X86_V4",
    },
    "another processor": {"OPENBLAS_CORETYPE": "Sandybridge", "OPENBLAS_NUM_THREADS": "2"},
}


def program(*arguments, **surroundings):
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, env=os.environ | surroundings, capture_output=True, text=True, check=False
    )


def promises_kept(*arguments, **surroundings):
    run = program(*arguments, **surroundings)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.mark.long
@pytest.mark.kernels
def test_this_machine_computes_what_others_do():
    report = compare_digests()
    assert report.ok, report
    assert len(report.digests) >= 38
    assert all(one.digits is None for one in report.digests if one.promised is None)


@pytest.mark.slow
@pytest.mark.parametrize("surroundings", SURROUNDINGS.values(), ids=SURROUNDINGS)
def test_other_surroundings_compute_the_same(surroundings):
    promises_kept(DIGESTS, **surroundings)


@pytest.mark.slow
@pytest.mark.parametrize("path", cpu_paths())
def test_all_instructions_compute_the_same_without_docstrings_and_in_any_order(path):
    arguments = ("-OO", DIGESTS, "--path", path, "--json")
    printed = json.loads(promises_kept(*arguments, PYTHONHASHSEED="7"))
    assert printed["verdict"] == "as promised"


@pytest.mark.slow
def test_what_is_written_is_expected_from_then_on(tmp_path):
    for file in DIGESTS.glob("*.py"):
        shutil.copy(file, tmp_path)
    expected = tmp_path / "expected.json"
    promises_kept(tmp_path, "--write", expected)
    values = json.loads(expected.read_text())
    assert values["bytes"] == json.loads((DIGESTS / "expected.json").read_text())["bytes"]
    values["bytes"]["path: Chirp"] = "another"
    expected.write_text(json.dumps(values))
    differs = program(tmp_path)
    assert differs.returncode == 1
    assert re.findall(r"(\S.*?) {2,}.*differs", differs.stdout) == ["path: Chirp"]


def test_a_digest_tells_bytes_shapes_and_types_apart():
    numbers = np.array([1.0, 2.0])
    assert digest_of([numbers]) == digest_of([[1.0, 2.0]])
    others = [[np.nextafter(numbers, 3)], [numbers[:, None]], [numbers.astype(int)], [[1.0], [2.0]]]
    assert len({digest_of(arrays) for arrays in ([numbers], *others)}) == 5
    assert digest_of([[np.nan]]) == digest_of([[-np.nan]])
    assert digest_of([[0.0]]) != digest_of([[-0.0]])


def test_the_digits_to_which_numbers_agree():
    for number, digits in (
        *((2.0, None), (2.000001, 6), (2.1, 1), (4.0, -1)),
        *((np.nan, -1), (2 + 5e-16, 15)),
    ):
        assert digits_of(np.array([number, -3.0]), np.array([2.0, -3.0])) == digits
        assert digits_of(np.array([number]), np.array([2.0, -3.0])) == -1


def test_some_numbers_stand_for_many():
    assert some_of(np.arange(100).reshape(10, 10)).tolist()[::11] == [0, 99]
    assert some_of(np.arange(3)).tolist() == [0, 1, 2]


def test_a_broken_promise_is_told():
    def report(*digests):
        return DigestReport(digests=digests, surroundings="here")

    kept = Digest(name="path", promised=None, digits=None)
    good = Digest(name="batch", promised=9, digits=11)
    assert report(kept, good).ok
    assert "as promised, of 2   2" in str(report(kept, good))
    for broken in (
        Digest(name="path", promised=None, digits=-1),
        Digest(name="path", promised=None, digits=15),
        Digest(name="batch", promised=9, digits=8),
    ):
        assert not report(kept, broken).ok
        assert "not as promised" in str(report(kept, broken))
        assert str(report(kept, broken)).rstrip().endswith("differs")
