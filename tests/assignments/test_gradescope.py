"""Gradescope's results.json: to its specification, small enough, and nothing of hidden tests."""

import json
import math
import re

import pytest

from graded_results import SECRET, graded, hidden, reports, submission
from html_outline import Outline

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
