"""The benchmark of graded runs runs and says what it found."""

import json

import pytest

import benches
from bench_grading import run


@pytest.mark.long
def test_the_program_prints_numbers_for_scripts(monkeypatch, capsys):
    few = {"rounds": 1, "seconds": 0.01, "isolation": "auto"}
    monkeypatch.setattr(run.run_grading_bench, "__kwdefaults__", few)
    benches.main(["grading", "--rounds", "1", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert list(found["steps"]) == [*run.KINDS]
    for row in found["steps"].values():
        assert row["ratio"] == pytest.approx(row["worker"] / row["here"])
        assert row["more"] == pytest.approx(row["worker"] - row["here"])
    assert found["start"] > 0
