"""Points: they add up as they are shown, and only all are all."""

import pytest

from graded_results import graded, submission
from robsim.assignments import ClassResult
from robsim.assignments._points import fraction_of, number, of_most
from robsim.assignments._reports import gradescope, junit_xml, marks_table, student_text
from robsim.assignments._reports.pages.student import student_page


def test_only_all_are_all_and_only_none_are_none():
    for points, most, shown in [
        (4.0, 4.0, 4.0),
        (0.0, 4.0, 0.0),
        (3.9999, 4.0, 3.99),
        (0.0001, 4.0, 0.01),
        (10 / 3, 4.0, 3.33),
        (2.675, 4.0, 2.67),
        (1 / 3, 1 / 3, 1 / 3),
    ]:
        assert graded(points=points, most=most).points == pytest.approx(shown, abs=1e-12)
    thirds = submission(tests=[graded(str(i), points=4 / 3, most=2.0) for i in range(3)])
    assert (thirds.points, thirds.most) == (3.99, 6.0)


def test_points_agree_wherever_they_are_read():
    parts = [graded(str(i), points=points, most=2.0) for i, points in enumerate((1.7633, 1.7634))]
    result = submission(tests=parts)  # 3.5267: 3.53 if it were rounded at the end
    texts = {
        "terminal": str(ClassResult(name="hw1", results=(result, result))),
        "report": str(result),
        "text": student_text(result),
        "page": student_page(result, {}),
        "table": marks_table([result]),
        "junit": junit_xml([result]).decode(),
        "json": result.to_json(),
        "gradescope": str(gradescope(result)),
    }
    assert {where for where, text in texts.items() if "3.53" in text or "1.763" in text} == set()
    for where in ("terminal", "report", "text", "page", "table", "junit"):
        assert "3.52" in texts[where], where


def test_points_are_read_without_zeros_at_the_end():
    assert [number(x) for x in (4.0, 2.5, 0.05, 10.0, 0.0)] == ["4", "2.5", "0.05", "10", "0"]
    assert of_most(0.5, 1.0) == "0.5 of 1 point"
    assert of_most(2.0, 4.0) == "2 of 4 points"
    assert [fraction_of(1, 4), fraction_of(4, 4), fraction_of(0, 0)] == [0.25, 1.0, 1.0]
