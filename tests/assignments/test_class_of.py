"""A small one of the classes by which time and memory of grading are measured."""

import re

import pytest

import class_of


@pytest.mark.slow
def test_a_small_class_comes_out_as_promised(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["class_of", "--students", "3", "--jobs", "2"])
    status = class_of.main()
    said = capsys.readouterr().out
    assert status == 0, said
    tests = sum(int(n) for n in re.findall(r"all points in \d+ of (\d+) tests", said))
    assert tests == 12
    assert "could not be graded: 0" in said
