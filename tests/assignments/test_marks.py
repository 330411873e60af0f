"""Tables of marks: columns for platforms, and results.json of Gradescope."""

import csv
import io
import json
import math
import re

import pandas as pd
import pytest

from graded_results import SECRET, graded, hidden, reports, score, submission
from html_outline import Outline
from robsim.teach import ByHand

# --- tables


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


# --- Gradescope


VISIBILITIES = {"hidden", "after_due_date", "after_published", "visible"}
FORMATS = {"text", "html", "simple_format", "md", "ansi"}
NUMBER = (int, float)

# Fields, their types and choices, as in the published specification of autograders.
BOTH = {"score": NUMBER, "output": str, "output_format": FORMATS, "visibility": VISIBILITIES}
BOTH |= {"extra_data": dict}
TOP = BOTH | {"execution_time": NUMBER, "test_output_format": FORMATS, "test_name_format": FORMATS}
TOP |= {"stdout_visibility": VISIBILITIES, "tests": list, "leaderboard": list}
TEST = BOTH | {"max_score": NUMBER, "status": {"passed", "failed"}, "name": str, "number": str}
TEST |= {"name_format": FORMATS, "tags": list}


def check_fields(content, allowed):
    for key, value in content.items():
        kind = allowed[key]
        if isinstance(kind, set):
            assert value in kind, (key, value)
        else:
            assert isinstance(value, kind), (key, value)
            assert not isinstance(value, bool), key
        if kind == NUMBER:
            assert math.isfinite(value), key


def check_results(content):
    """Hold what was written against the specification."""
    check_fields(content, TOP)
    for test in content.get("tests", []):
        check_fields(test, TEST)
        assert all(isinstance(each, str) for each in test.get("tags", []))
        assert "\r" not in test.get("output", "")
    scores = [test for test in content.get("tests", []) if "score" in test]
    assert "score" in content or len(scores) == len(content["tests"])


@pytest.fixture
def results(tmp_path):
    """Return a function that writes tests to a file, and returns what is in it, checked."""

    def written(*tests, **options):
        file = tmp_path / "results.json"
        reports.write_gradescope(file, submission(tests=tests), **options)
        assert [each.name for each in tmp_path.iterdir()] == ["results.json"]
        content = json.loads(file.read_text("ascii"), parse_constant=pytest.fail)
        check_results(content)
        return content

    return written


def test_points_and_texts_are_there(results):
    content = results(graded(), graded("second", status="passed", points=4.0))
    first, second = content["tests"]
    assert content["score"] == 6.92
    assert (first["score"], first["max_score"], first["status"]) == (2.92, 4.0, "failed")
    assert (second["score"], second["status"]) == (4.0, "passed")
    assert first["number"] == "1.1"
    assert content["stdout_visibility"] == "hidden"
    text = Outline(first["output"]).text
    for wanted in ("2.92 of 4 points", "stays behind", "wrap the innovation", "run 7"):
        assert wanted in text


@pytest.mark.parametrize("when", ["after_published", "after_due_date", "visible"])
def test_of_hidden_tests_nothing_shows_but_points_and_sentence(results, when):
    content = results(graded(), hidden(), pictures={"others": b"png"}, hidden=when)
    assert SECRET not in json.dumps(content)
    public, other = content["tests"]
    assert (public["visibility"], other["visibility"]) == ("visible", when)
    assert "1 of 4 points" in Outline(other["output"]).text
    # What stands above all tests is seen before.
    assert "2.92 of 4 points" in content["output"]
    assert not re.search(r"3\.92|\b8\b", content["output"])


def test_a_score_of_a_public_test_is_on_the_leaderboard_if_asked_for(results):
    both = score("bias", statistic=0.25, low=0.5, low_zero=0.1)
    tests = [graded(failed=(), scores=(score(), both)), hidden(scores=(score(),), failed=())]
    assert "leaderboard" not in results(*tests)
    (entry,) = results(*tests, leaderboard="estimate.position")["leaderboard"]
    assert (entry["value"], entry["order"]) == (1.5, "asc")
    (entry,) = results(*tests, leaderboard="estimate.bias")["leaderboard"]
    assert entry["value"] == 4  # a quarter is as far off as four times
    # A submission that fails in hard runs would be measured in easy ones alone.
    none = graded(failed=(), scores=(score(statistic=math.nan),))
    for test, name in ((graded(), "estimate"), (none, "estimate"), (tests[1], "others")):
        assert "leaderboard" not in results(test, leaderboard=f"{name}.position")


def test_what_a_teacher_changed_is_told_with_the_hidden_points(results):
    changed = ByHand(points=3.0, comment="too short")
    content = reports.gradescope(submission(by_hand=changed))
    check_results(content)
    assert content["score"] == 3
    assert "too short" not in content["output"]
    *_, said = content["tests"]
    assert said["visibility"] == "after_published"
    assert "too short" in said["output"]


def test_what_could_not_be_graded_has_no_score(results):
    failed, other = results(graded(status="error", whose="grader", points=0.0), graded("b"))[
        "tests"
    ]
    assert not {"score", "max_score"} & set(failed)
    assert "score" in other


def test_a_result_of_half_way_is_valid():
    half = submission(tests=[graded(status="not run", points=0.0)], is_done=False)
    check_results(reports.gradescope(half))
    check_results(reports.gradescope(submission(tests=[])))
    with pytest.raises(ValueError, match="hidden"):
        reports.gradescope(half, hidden="hidden")


def test_pictures_are_in_it_as_long_as_they_are_small(results):
    names = [f"test{i}" for i in range(15)]
    tests = [graded(name) for name in names]
    small, large = b"p" * 140_000, b"p" * 160_000  # as text a third more; the limit is 200 KiB
    content = results(*tests, pictures=dict.fromkeys(names, small))
    shown = ["<img" in test["output"] for test in content["tests"]]
    assert shown == [True] * 11 + [False] * 4
    assert len(json.dumps(content)) < 2.1 * 2**20
    content = results(*tests, pictures=dict.fromkeys(names, large))
    assert not any("<img" in test["output"] for test in content["tests"])
    content = results(graded(picture=None), pictures={"estimate": b"png"})
    assert "<img" not in content["tests"][0]["output"]
