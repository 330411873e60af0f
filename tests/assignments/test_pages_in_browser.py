"""The pages of grading in a browser: nothing is loaded, tables sort, nothing sticks out."""

import io

import pytest
from PIL import Image

from graded_results import NASTY, PROGRAM, graded, hidden, submission
from robsim.assignments._reports import program_of, write_class, write_student

pytestmark = pytest.mark.long


@pytest.fixture
def open_page(chromium):
    """Return a function that opens a file in a browser; what it complains of fails the test."""
    contexts, complaints = [], []

    def open_it(file, *, size=(1000, 800), theme="light"):
        width, height = size
        context = chromium.new_context(
            viewport={"width": width, "height": height}, color_scheme=theme, offline=True
        )
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
    write_student(tmp_path, submission(tests=[nasty, hidden()]), pictures={"estimate": picture()})
    return tmp_path / "index.html"


@pytest.fixture
def class_file(tmp_path):
    points = {"s10": 0.5, "s2": 4.0, "s1": 0.0, "<b>": 3.0}
    results = [
        submission(name, [graded(points=each, status="passed" if each == 4 else "failed")])
        for name, each in points.items()
    ]
    programs = {name: program_of({"state.py": PROGRAM.encode()}) for name in ("s1", "s2")}
    write_class(tmp_path, results, programs=programs)
    return tmp_path / "class.html"


@pytest.mark.parametrize(("theme", "width"), [("light", 320), ("dark", 1000)])
def test_pages_fit_any_screen_can_be_read_and_printed(open_page, student, class_file, theme, width):
    tab = open_page(student, size=(width, 800), theme=theme)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.evaluate("document.images[0].naturalWidth") == 900
    grounds = {"light": "rgb(243, 244, 246)", "dark": "rgb(15, 17, 21)"}
    assert tab.evaluate(GROUND) == grounds[theme]
    for file in (student, class_file):
        tab = open_page(file, theme=theme)
        assert tab.evaluate(WEAK_TEXTS) == []
        assert tab.pdf().startswith(b"%PDF")
        tab.emulate_media(media="print", color_scheme=theme)
        assert tab.evaluate(GROUND) == "rgb(255, 255, 255)"


GROUND = "getComputedStyle(document.body).backgroundColor"


#: Texts of less contrast than WCAG's 4.5 to 1, on the ground that is nearest behind them.
WEAK_TEXTS = """() => {
  const numbers = (color) => color.match(/[\\d.]+/g).map(Number);
  const luminance = (color) => numbers(color).slice(0, 3)
    .map((c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = (element) => {
    for (; element; element = element.parentElement) {
      const color = getComputedStyle(element).backgroundColor;
      if (numbers(color)[3] !== 0) return color;
    }
    return "rgb(255, 255, 255)";
  };
  const weak = [];
  for (const element of document.querySelectorAll("body *:not(script, svg *)")) {
    const texts = [...element.childNodes].filter((n) => n.nodeType === 3 && n.data.trim());
    if (!texts.length) continue;
    const [a, b] = [getComputedStyle(element).color, ground(element)].map(luminance);
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) weak.push([element.tagName, texts[0].data.slice(0, 40), contrast]);
  }
  return weak;
}"""


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
