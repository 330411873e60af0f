"""The benchmark of graded runs runs and says what it found."""

import json

import pytest

from commands import command
from robsim.bench._grading import run


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
