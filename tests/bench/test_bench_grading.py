"""The benchmark of graded runs runs and says what it found."""

import json
import re

import pytest

from commands import command
from robsim.bench._grading import run
from robsim.bench._grading.result import GradingBench


@pytest.mark.long
def test_the_command_prints_numbers_for_scripts(tmp_path, monkeypatch):
    few = {"rounds": 1, "seconds": 0.01, "isolation": "auto"}
    monkeypatch.setattr(run.run_grading_bench, "__kwdefaults__", few)
    ended = command("bench", "--grading", "--rounds", "1", "--json", cwd=tmp_path)
    assert ended.exit_code == 0, ended.stderr
    found = json.loads(ended.stdout)
    assert list(found["steps"]) == [*run.KINDS]
    for row in found["steps"].values():
        assert row["ratio"] == pytest.approx(row["worker"] / row["here"])
        assert row["more"] == pytest.approx(row["worker"] - row["here"])
    assert found["start"] > 0


def test_the_table():
    bench = GradingBench(
        steps={"480_clean": (80e-6, 152e-6), "1200_clean": (1e-3, 0.9e-3)},
        start=0.0214,
        isolation="isolation: process",
    )
    text = str(bench)
    assert re.search(r"480_clean +0\.080 +0\.152 +1\.90 +0\.072", text)
    assert re.search(r"1200_clean +1\.000 +0\.900 +0\.90 +-0\.100", text)
    assert re.search(r"a run of one step \(ms\) +21", text)
    assert "isolation: process" in text
