"""Texts of students in reports: text everywhere, whatever they are."""

import csv
import io
import json
import re
from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzing import fuzzed
from graded_results import (
    NASTY,
    PROGRAM,
    any_submissions,
    class_page,
    reports,
    saying,
    student_page,
    submission,
    texts,
)
from html_outline import Outline

# What no text may have: controls, what turns the text around it, halves, what is no character.
HARMFUL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]"
)
ELEMENTS = """
    html head meta title style script body div header main section footer table caption
    thead tbody tr th td p b i a span h1 h2 h3 figure figcaption img pre code ul li details
    summary dl dt dd button svg rect line text circle polyline g input label
"""
ELEMENTS = {*ELEMENTS.split()}
ATTRIBUTES = """
    lang charset http-equiv content name class style href src alt id role aria-label
    aria-hidden aria-labelledby scope title type data-value viewbox x y x1 x2 y1 y2 width
    height rx cx cy r points text-anchor
"""
ATTRIBUTES = {*ATTRIBUTES.split()}


def check_page(page):
    assert not HARMFUL.search(page)
    outline = Outline(page)
    assert set(outline.names) <= ELEMENTS
    assert {name for _, found in outline.elements for name in found} <= ATTRIBUTES
    assert all(src.startswith("data:image/png;base64,") for src in outline.attributes("src"))
    styles = outline.attributes("style")
    assert all(re.fullmatch(r"(left:[\d.]+%;?)?(width:[\d.]+%)?", style) for style in styles)
    return outline


@pytest.mark.long
def test_no_nasty_text_breaks_a_report():
    for text in NASTY:
        result = saying(text)
        check_students_page(result)
        check_class_page([result, submission()])
        check_other_formats(result)


@pytest.mark.fuzz
@fuzzed
@given(any_submissions())
def test_no_text_breaks_a_report_of_a_submission(result):
    check_students_page(result)
    check_other_formats(result)


@pytest.mark.fuzz
@fuzzed
@given(st.lists(any_submissions(), min_size=1, max_size=3))
def test_no_text_breaks_the_page_of_a_class(results):
    check_class_page(results)


def check_students_page(result):
    for page in (
        student_page(reports.for_student(result), {"test0": b"png"}),
        student_page(result, {"test0": b"png"}, for_teacher=True),
    ):
        outline = check_page(page)
        assert "script" not in outline.names
        assert outline.names.count("section") == len(result.tests)


def check_class_page(results):
    links = {result.student: f"{result.student}/teacher.html" for result in results}
    outline = check_page(class_page(results, links=links))
    assert outline.names.count("script") == 1
    links = [link for link in outline.attributes("href") if not link.startswith("#")]
    # None has a scheme, or leads to another machine.
    assert not any(re.match(r"[\w+.-]*:|//", link) for link in links)


def check_other_formats(result):
    text = reports.student_text(result)
    assert not HARMFUL.search(text)

    content = reports.gradescope(result, pictures={"test0": b"png"})
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    for test in content["tests"]:
        assert not HARMFUL.search(test["name"] + test["output"])
        assert set(Outline(test["output"]).names) <= ELEMENTS - {"script", "style", "a"}

    for columns in ("robsim", "moodle", "canvas", "blackboard"):
        table = reports.marks_table([result, submission("s2", [])], columns=columns)
        rows = list(csv.reader(io.StringIO(table, newline="")))
        assert len(rows) == (4 if columns == "canvas" else 3)
        assert len({len(row) for row in rows}) == 1
        assert not HARMFUL.search(table.replace("\r\n", ""))
        for cell in chain(*rows):
            assert not re.match(r"\s*[=+\-@\uff0b\uff0d\uff1d\uff20]", cell)


@pytest.mark.fuzz
@fuzzed
@given(texts)
def test_text_in_a_page_stays_the_same_text(text):
    page = Outline(student_page(saying(text), {"test0": b"png"}))
    if text.isprintable():
        marks = r"[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff]{4,}"
        if not re.search(marks, text):
            assert text in page.text
            assert page.attributes("alt") == [f"Run 4, the worst. {text}".rstrip()]


@pytest.mark.long
def test_programs_are_shown_as_text(tmp_path):
    for text in NASTY:
        source = f"# {text}\nname = {text!r}\n{PROGRAM}".encode("utf-8", "surrogatepass")
        programs = {
            name: reports.program_of({f"{name}.py": source + more})
            for name, more in ((text or "a", b""), ("b", b"\ndef f(): return 1"))
        }
        reports.write_class(tmp_path, [submission()], programs=programs)
        page = (tmp_path / "class.html").read_text("utf-8")
        assert "np.linalg.inv" in page
        check_page(page)
