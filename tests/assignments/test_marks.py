"""Tables of marks: columns as platforms import them, read back by others."""

import csv
import io

import pandas as pd
import pytest

from graded_results import graded, hidden, reports, submission


def rows(results, **options):
    return list(csv.reader(io.StringIO(reports.marks_table(results, **options), newline="")))


def test_pandas_reads_the_points():
    results = [
        submission("s001"),
        submission(
            "s002", [graded(status="passed", points=4.0), hidden(status="error", points=0.0)]
        ),
    ]
    table = pd.read_csv(io.StringIO(reports.marks_table(results)), index_col="student")
    assert list(table.columns) == [
        *("points", "most", "percent", "estimate", "others", "is_done", "notes")
    ]
    assert table.loc["s001", "points"] == 3.92
    assert table.loc["s001", "percent"] == 49.0
    assert table.loc["s002", "estimate"] == 4.0
    assert pd.isna(table.loc["s002", "others"])  # nobody won or lost it


def test_canvas_takes_its_columns():
    # The rules of Canvas' importer: the columns up to Section are of the student.
    head, possible, *students = rows(
        [submission("doejane_LATE_1042_7781_hw3.zip"), submission("jd42")], columns="canvas"
    )
    assert "Student" in head[0]
    assert "ID" in head[1]
    assert head[2:5] == ["SIS User ID", "SIS Login ID", "Section"]
    assert head[5:] == ["A state estimator"]
    assert "Points Possible" in possible[0]
    assert possible[5] == "8"
    assert students == [
        ["doejane", "1042", "", "", "", "3.92"],
        ["jd42", "", "", "jd42", "", "3.92"],
    ]


def test_moodle_takes_its_columns():
    head, downloaded, other = rows(
        [submission("Jané Doe_1042_assignsubmission_file"), submission("jd42")], columns="moodle"
    )
    # Those without which its importer refuses a worksheet.
    assert {"Identifier", "Grade", "Last modified (grade)"} <= set(head)
    line = dict(zip(head, downloaded, strict=True))
    assert line["Identifier"] == "Participant 1042"
    assert line["Full name"] == "Jané Doe"
    assert (line["Grade"], line["Maximum grade"]) == ("3.92", "8")
    assert "The estimate stays behind" in line["Feedback comments"]
    assert other[:2] == ["jd42", "jd42"]


def test_feedback_says_the_same_once():
    tests = [graded(str(i), points=0.0, sentence="it is empty") for i in range(3)]
    (_, line) = rows([submission("jd42", tests=tests)], columns="moodle")
    assert line[-1].count("it is empty.") == 1
    assert line[-1].count("0 of 4 points.") == 3


def test_blackboard_takes_its_columns():
    result = submission("Homework 3_jd42_attempt_2026-01-02-10-11-12_hw3.zip")
    table = rows([result], columns="blackboard", title="Hw 3 [Total Pts: 8 Score] |123")
    assert table == [["Username", "Hw 3 [Total Pts: 8 Score] |123"], ["jd42", "3.92"]]


def test_names_are_no_formulas():
    results = [submission(name) for name in ("=cmd|' /C calc'!A0", "@SUM(1)", "+1", "-1", "\t=1")]
    for columns in ("robsim", "moodle", "canvas", "blackboard"):
        for row in rows(results, columns=columns):
            assert not any(cell.lstrip().startswith(("=", "+", "-", "@")) for cell in row)
    with pytest.raises(ValueError, match="columns"):
        reports.marks_table(results, columns="sakai")
