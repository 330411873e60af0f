"""The page of a class, and its files."""

import csv
import re

import numpy as np
import pytest

from graded_results import PROGRAM, graded, hidden, reports, submission
from html_outline import Outline


def results():
    return [
        submission("s002", [graded(status="passed", points=4.0), hidden()]),
        submission(
            "s001", [graded(status="failed", points=0.0), hidden(status="error", points=0.0)]
        ),
        submission("müller", is_done=False),
    ]


def written(folder, **options):
    reports.write_class(folder, results(), **options)
    return Outline((folder / "class.html").read_text("utf-8"))


def programs_of(*names):
    return {name: reports.program_of({f"{name}.py": PROGRAM.encode()}) for name in names}


def test_all_files_are_written(tmp_path):
    page = written(tmp_path / "new")
    table = (tmp_path / "new/class.csv").read_text("utf-8")
    rows = list(csv.reader(table.splitlines()))
    assert [row[0] for row in rows] == ["student", "müller", "s001", "s002"]
    for wanted in ("mean 2.97, median 3.92 of 8", "2 of 3", "s001 (0), müller (2.92)", "(hidden)"):
        assert wanted in page.text
    assert page.attributes("href") == [
        *("m%C3%BCller/teacher.html", "s001/teacher.html", "s002/teacher.html")
    ]
    # The table can be sorted by numbers: points, two tests, seconds.
    assert len([float(value) for value in page.attributes("data-value")]) == 3 * 4
    assert page.names.count("button") == 5
    # Histograms count none, ten parts and all.
    assert page.names.count("rect") == 3 * 12
    with pytest.raises(ValueError, match="result"):
        reports.write_class(tmp_path, [])


def test_pseudonyms_leave_no_name_and_no_text(tmp_path):
    paths = {"estimate": {"s001": np.zeros((3, 2)), "müller": np.ones((3, 2))}}
    names = {"s001": "abc", "s002": "def", "müller": "ghi"}
    programs = programs_of("s001", "s002")
    written(tmp_path, programs=programs, paths=paths, pseudonym=names.__getitem__)
    for file in tmp_path.iterdir():
        text = file.read_text("utf-8")
        assert not re.search(r"s00\d|müller|stays behind|plot\.py|estimate_state\.py", text)
        assert "printed by me" not in text
    page = (tmp_path / "class.html").read_text()
    assert "abc and def" in page
    assert "np.linalg" not in page


def test_similar_programs_are_a_hint_but_for_what_was_given(tmp_path):
    programs = programs_of("s001", "s002")
    page = written(tmp_path, programs=programs)
    assert "s001 and s002: 100 % of s001, 100 % of s002" in page.text
    assert "gain = self.P @ np.linalg.inv" in page.text
    for nothing in ({"programs": {}}, {"programs": programs, "given": [programs["s001"]]}):
        assert "No two programs" in written(tmp_path, **nothing).text
    assert "Similar programs" not in written(tmp_path).text


def test_paths_lie_on_one_floor_those_with_all_points_on_top(tmp_path):
    rows = np.array([[100.0, 200.0], [300.0, 600.0], [np.nan, np.nan]])
    paths = {"estimate": dict.fromkeys(("s002", "s001", "müller"), rows)}
    page = written(tmp_path, paths=paths)
    assert page.attributes("points") == ["100.0,200.0 300.0,600.0"] * 3
    assert [name for name in page.attributes("class") if name.startswith("path ")] == [
        *("path none", "path some", "path all")
    ]
    assert "s001: 0 of 4" in page.text
    nowhere = {"estimate": {"s001": np.full((3, 2), np.nan)}, "unknown": {"s001": np.zeros((1, 2))}}
    assert "polyline" not in written(tmp_path, paths=nowhere).names
