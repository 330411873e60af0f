"""The pages of grading in a browser: nothing is loaded, tables sort, nothing sticks out."""

import io

import pytest
from PIL import Image

from graded_results import NASTY, PROGRAM, graded, hidden, reports, submission

pytestmark = pytest.mark.long


@pytest.fixture
def open_page(chromium):
    """Return a function that opens a file in a browser; what it complains of fails the test."""
    contexts, complaints = [], []

    def open_it(file, *, size=(1000, 800)):
        width, height = size
        viewport = {"width": width, "height": height}
        context = chromium.new_context(viewport=viewport, offline=True)
        contexts.append(context)
        tab = context.new_page()
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("requestfailed", lambda request: complaints.append(request.url))
        tab.goto(file.as_uri())
        return tab

    yield open_it
    for context in contexts:
        context.close()
    assert complaints == []


def picture():
    content = io.BytesIO()
    Image.new("RGB", (900, 370), "white").save(content, "PNG")
    return content.getvalue()


@pytest.fixture
def student(tmp_path):
    nasty = graded(output="\n".join(NASTY), finding="x" * 500, sentence=NASTY[1])
    reports.write_student(
        tmp_path, submission(tests=[nasty, hidden()]), pictures={"estimate": picture()}
    )
    return tmp_path / "index.html"


@pytest.fixture
def class_file(tmp_path):
    points = {"s10": 0.5, "s2": 4.0, "s1": 0.0, "<b>": 3.0}
    results = [
        submission(name, [graded(points=each, status="passed" if each == 4 else "failed")])
        for name, each in points.items()
    ]
    programs = {name: reports.program_of({"state.py": PROGRAM.encode()}) for name in ("s1", "s2")}
    reports.write_class(tmp_path, results, programs=programs)
    return tmp_path / "class.html"


def test_pages_fit_a_narrow_screen_and_can_be_printed(open_page, student):
    tab = open_page(student, size=(320, 800))
    assert tab.evaluate("document.documentElement.scrollWidth") <= 320
    assert tab.evaluate("document.images[0].naturalWidth") == 900
    assert tab.pdf().startswith(b"%PDF")


def names(tab):
    return tab.locator("table.sortable tbody th").all_text_contents()


def test_the_table_is_sorted_by_the_heading_that_is_pressed(open_page, class_file):
    tab = open_page(class_file)
    assert names(tab) == ["<b>", "s1", "s10", "s2"]
    points = tab.locator("table.sortable th button", has_text="Points")
    points.click()
    assert names(tab) == ["s2", "<b>", "s10", "s1"]
    points.click()
    assert names(tab) == ["s1", "s10", "<b>", "s2"]
    assert tab.locator("th[aria-sort]").all_text_contents() == ["Points"]
    tab.locator("table.sortable th button", has_text="Submission").press("Enter")
    assert names(tab)[-3:] == ["s1", "s2", "s10"]
    # Similar programs stand side by side.
    tab.locator("summary", has_text="s1 and s2").click()
    left, right = tab.locator("details .pair pre").all()
    assert left.bounding_box()["x"] < right.bounding_box()["x"]
