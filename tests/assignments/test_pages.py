"""The pages of grading: of a class, of a student, in a browser."""

import csv
import io
import math
import re

import numpy as np
import pytest
from PIL import Image

from graded_results import (
    NASTY,
    PROGRAM,
    SECRET,
    FailedRun,
    class_page,
    graded,
    hidden,
    reports,
    score,
    student_page,
    submission,
)
from html_outline import Outline
from robsim.teach import SubmissionResult

# --- the page of a class


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
    (tmp_path / "new/s002").mkdir(parents=True)
    (tmp_path / "new/s002/teacher.html").touch()
    page = written(tmp_path / "new")
    table = (tmp_path / "new/class.csv").read_text("utf-8")
    rows = list(csv.reader(table.splitlines()))
    assert [row[0] for row in rows] == ["student", "müller", "s001", "s002"]
    for wanted in ("mean 2.97, median 3.92 of 8", "2 of 3", "s001 (0), müller (2.92)", "(hidden)"):
        assert wanted in page.text
    assert page.attributes("href") == [
        *("m%C3%BCller/index.html", "s001/index.html", "s002/teacher.html")
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
    for name in ("class.html", "class.csv"):
        text = (tmp_path / name).read_text("utf-8")
        assert not re.search(r"s00\d|müller|stays behind|plot\.py|estimate_state\.py", text)
        assert "printed by me" not in text
    page = (tmp_path / "class.html").read_text()
    assert "abc, def" in page
    programs["s002"] = reports.program_of({"state.py": PROGRAM.encode() + b"def f(): return 1"})
    page = written(tmp_path, programs=programs, pseudonym=names.__getitem__).text
    assert "abc and def" in page
    assert "np.linalg" not in page


def test_similar_programs_are_a_hint_but_for_what_was_given(tmp_path):
    programs = programs_of("s001", "s002")
    page = written(tmp_path, programs=programs)
    assert "s001, s002: 2 alike, 17 lines" in page.text
    assert page.attributes("href").count("#alike") == 2
    longer = reports.program_of({"state.py": PROGRAM.encode() + b"def f(): return 1"})
    page = written(tmp_path, programs={**programs, "s002": longer})
    assert "s001 and s002: 100 % of s001" in page.text
    assert "gain = self.P @ np.linalg.inv" in page.text
    for nothing in ({"programs": {}}, {"programs": programs, "given": [programs["s001"]]}):
        assert "No two programs" in written(tmp_path, **nothing).text
    assert "Similar programs" not in written(tmp_path / "new").text
    for broken in ("", "{}", "[" * 10**5, '{"groups": 1, "pairs": [2]}'):
        (tmp_path / "similar.json").write_text(broken)
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


# --- the page of a student


def png(color="red"):
    content = io.BytesIO()
    Image.new("RGB", (8, 8), color).save(content, "PNG")
    return content.getvalue()


def texts_of(result):
    """What stands on the page and in the text of a result."""
    return Outline(student_page(result, {})).text, reports.student_text(result)


def test_the_page_has_what_helps_and_needs_no_other_file():
    page = Outline(student_page(reports.for_student(submission()), {"estimate": png()}))
    for wanted in (
        *("s001", "A state estimator", "3.92 of 8 points", "2.92 of 4 points", "73 % of 4 points"),
        *("1.5 times", "up to 1.14", "from 3.2 on", "43 px off in step 33", "wrap the innovation"),
        *("1 of 10 runs", "estimate_state.py, line 23: ValueError: no covariance"),
        *("printed by me", "--only estimate", "plot.py is not used", "robsim 0.1.0"),
    ):
        assert wanted in page.text
    assert "Landlock" not in page.text
    assert page.attributes("src")[0].startswith("data:image/png;base64,")
    assert not {"script", "link", "iframe", "object", "form", "base"} & set(page.names)
    assert any("default-src 'none'" in content for content in page.attributes("content"))
    # It can be read without seeing it.
    assert page.attributes("lang") == ["en"]
    assert page.attributes("alt") == ["Run 4, the worst. The estimate is 43 px off in step 33."]
    ids = page.attributes("id")
    assert len(ids) == len(set(ids)) == 2
    assert {link[1:] for link in page.attributes("href")} == set(ids)


def test_a_name_of_moodle_is_read_as_the_name_in_it():
    result = submission("Jané O'Doe_1042_assignsubmission_file_")
    for text in (*texts_of(result), class_page([result])):
        assert "Jané O" in text
        assert "assignsubmission" not in text


def test_of_hidden_tests_there_are_points_and_a_sentence_alone():
    seen = reports.for_student(submission())
    page = student_page(seen, {"others": png(), "estimate": png()})
    for text in (page, reports.student_text(seen), seen.to_json()):
        assert SECRET not in text
        assert "4711" not in text
        assert "In other worlds" in text
        assert "Not as good there." in text
    assert page.count("<img") == 1
    of_teacher = student_page(submission(), {"others": png()}, for_teacher=True)
    for wanted in (SECRET, "--play others --run 4", "Landlock"):
        assert wanted in of_teacher


def test_a_bar_has_limits_runs_and_result_in_their_places_and_holds_any_number():
    test = graded(
        scores=(score(statistic=3.2, values=(2.0,) * 10, reference=(2.0,) * 10),), failed=()
    )
    page = student_page(submission(tests=[test]), {})
    places = {
        kind: [float(x) for x in re.findall(rf'class="{kind}[^"]*" style="left:([\d.]+)%', page)]
        for kind in ("mark", "run", "tick")
    }
    full, none = places["tick"]
    assert places["mark"] == [none]
    assert len(places["run"]) == 10
    assert 0 < places["run"][0] < full < none < 100
    for value in (float("nan"), float("inf"), 0.0, 1e300, -1.0):
        test = graded(scores=(score(statistic=value, values=(value,) * 2, reference=(value, 1.0)),))
        page = student_page(submission(tests=[test]), {})
        places = [float(x) for x in re.findall(r"(?:left|width):(-?[\d.]+)%", page)]
        assert places
        assert all(0 <= place <= 100 for place in places)


def test_a_dot_has_the_number_of_its_run_and_lies_where_its_run_alone_would_be():
    lost = {"unit": "%", "share": 0.0, "limit": 1.25, "zero": 2.0, "statistic": 2.0}
    scores = (score(), score("lost", values=(20.0,) * 8 + (60.0,), reference=(0.0,) * 9, **lost))
    test = graded(scores=scores)  # run 7 has failed
    page = student_page(submission(tests=[test]), {})
    dots = re.findall(r'class="run[^"]*" style="left:([\d.]+)%" title="Run (\d)', page)
    assert sorted(int(run) for _, run in dots) == sorted([*range(7), 8, 9] * 2)
    (at_limit, *_), (*_, worst) = dots[9:], dots
    full, none = re.findall(r'class="tick" style="left:([\d.]+)%', page)[2:]
    assert at_limit[0] == full
    assert float(worst[0]) > float(none)
    assert worst[1] == "9"
    assert "Run 9 is the worst in this score, with 60 %" in Outline(page).text
    unknown = score(values=(float("nan"), 9.0), reference=(2.0, 2.0))
    page = student_page(submission(tests=[graded(scores=(unknown,), failed=())]), {})
    assert "1 of 2 runs have no value, and count as the worst." in page


def test_a_picture_is_the_worst_in_a_score_whose_worst_run_is_the_same():
    far = (2.0, 2.0, 9.0)
    scores = (
        score(values=(math.nan,) * 3),
        score("heading", values=far, share=0.3),
        score("met", statistic=1.0),
    )
    for worst, said in ((2, "Run 2, the worst in error of the heading."), (1, "Run 1, the worst.")):
        test = graded(scores=scores, runs=3, failed=(), worst=worst)
        for text in texts_of(submission(tests=[test])):
            assert said in " ".join(text.split())
            assert "All points need runs with a value." in " ".join(text.split())


def test_of_a_score_that_loses_points_it_is_said_what_all_points_need():
    odd = {"unit": "", "low": 0.5, "low_zero": 0.1, "statistic": 0.25}
    lost = {"unit": "%", "share": 0.0, "values": (50.0,) * 9, "reference": (20.0,) * 9}
    scores = (
        score(statistic=1.5, limit=1.2),  # 1.5 times a geometric mean of 2.43 px
        score("odd", **odd),
        score("lost", **lost | {"statistic": 1.6, "limit": 1.25}),
        score("met", statistic=1.0, values=(2.0,), reference=(2.0,), fraction=0.9),
    )
    result = submission(tests=[graded(scores=scores, failed=())])
    for text in (*texts_of(result), reports.gradescope(result)["tests"][0]["output"]):
        text = " ".join(text.split())
        for wanted in ("20 % less: 2.92 px, instead of 3.65 px", "2 times as much", "within its"):
            assert wanted in text
        assert "64.0 % right ones, instead of 50.0 %" in text
        assert text.count("All points need") == 3
    fine = submission(tests=[graded(scores=(score(statistic=1.0, fraction=1.0),))])
    assert all("All points need" not in text for text in texts_of(fine))


def test_where_the_grader_failed_no_points_are_shown_and_what_is_not_done_is_said():
    test = graded(status="error", whose="grader", points=0.0, most=3.0, scores=())
    for text in texts_of(submission(tests=[test, graded("second")])):
        assert "3 of these 7 points" in text
        assert "0 of 3 points" not in text
    half = submission(tests=[graded(status="not run", points=0.0)], is_done=False)
    assert all("not run" in text for text in texts_of(half))
    pills = [name for name in Outline(student_page(half, {})).attributes("class") if "pill" in name]
    assert set(pills) == {"pill idle"}


def test_runs_that_failed_alike_are_told_together():
    place = {"slot": "control", "step": 3, "file": "control.py", "line": 7}
    failed = [FailedRun(run=run, reason="the same", **place) for run in (0, 2, 3)]
    failed.append(FailedRun(run=5, reason="no answer", slot="control"))
    lost = score(statistic=float("nan"), values=(), reference=(), fraction=0.0)
    test = graded(failed=tuple(failed), scores=(lost,), worst=None)
    for text in texts_of(submission(tests=[test])):
        assert text.count("the same") == 1
        assert "runs 0, 2, 3" in text
        assert "run 5" in text
        assert "error of the position" not in text  # of which there is nothing to say


def test_all_files_of_a_submission_are_written_and_pictures_of_before_are_shown_again(tmp_path):
    result, folder = submission(), tmp_path / "s001"
    pictures = {"estimate": png(), "others": png("blue")}
    reports.write_student(folder, result, pictures=pictures, teacher_page=True)
    assert {file.name for file in folder.iterdir()} == {
        *("index.html", "result.txt", "teacher.html", "result.json"),
        *("estimate.png", f"{SECRET}.png"),
    }
    assert SubmissionResult.from_json((folder / "result.json").read_text()) == result
    later = graded("later", picture=None, status="failed")
    for _ in range(2):
        assert SECRET not in (folder / "index.html").read_text()
        assert (folder / "index.html").read_text().count("<img") == 1
        assert (folder / "teacher.html").read_text().count("<img") == 2
        reports.write_student(folder, submission(tests=[graded(), hidden(), later]))


def test_only_all_points_are_all_and_only_none_are_none():
    for points, most, shown in [
        (3.9999, 4.0, 3.99),
        (0.0001, 4.0, 0.01),
        (10 / 3, 4.0, 3.33),
        (2.675, 4.0, 2.67),
        (1 / 3, 1 / 3, 1 / 3),
    ]:
        assert graded(points=points, most=most).points == pytest.approx(shown, abs=1e-12)


def test_points_agree_wherever_they_are_read():
    parts = [graded(str(i), points=points, most=2.0) for i, points in enumerate((1.7633, 1.7634))]
    result = submission(tests=parts)  # 3.5267: 3.53 if it were rounded at the end
    for text in (*texts_of(result), str(result), reports.marks_table([result])):
        assert "3.52" in text
        assert "3.53" not in text
        assert "1.763" not in text


# --- pages in a browser


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


def near(**changes):
    return graded(failed=(), points=3.7, scores=(score(statistic=1.2),), **changes)


@pytest.fixture
def class_file(tmp_path):
    points = {"s10": 0.5, "s2": 4.0, "s1": 0.0, "<b>": 3.0}
    results = [
        submission(name, [graded(points=each, status="passed" if each == 4 else "failed")])
        for name, each in points.items()
    ]
    results.append(submission("s3", [near()]))
    more = {"s1": "", "s2": "def f(): return 1"}
    programs = {
        name: reports.program_of({"state.py": (PROGRAM + text).encode()})
        for name, text in more.items()
    }
    reports.write_class(tmp_path, results, programs=programs)
    return tmp_path / "class.html"


@pytest.mark.long
def test_pages_fit_a_narrow_screen_and_can_be_printed(open_page, student):
    tab = open_page(student, size=(320, 800))
    assert tab.evaluate("document.documentElement.scrollWidth") <= 320
    assert tab.evaluate("document.images[0].naturalWidth") == 900
    printed = tab.locator("details pre")
    assert not printed.evaluate("text => text.checkVisibility()")
    tab.emulate_media(media="print")
    assert printed.evaluate("text => text.checkVisibility()")
    assert tab.pdf().startswith(b"%PDF")


def names(tab):
    cells = tab.locator("table.sortable tbody th:visible").all_text_contents()
    return [cell.removesuffix(" similar") for cell in cells]


@pytest.mark.long
def test_submissions_just_below_the_limit_can_be_shown_alone(open_page, class_file):
    tab = open_page(class_file)
    box = tab.get_by_label("just below the limit")
    box.check()
    assert names(tab) == ["s3"]
    box.uncheck()
    assert len(names(tab)) == 5
    assert tab.locator("td", has_text="≈").count() == 1


def test_just_below_the_limit_is_a_matter_of_scores_alone():
    partly = graded(failed=(), points=3.9, scores=(score(statistic=1.2), score(statistic=1.3)))
    failed = graded(scores=(score(statistic=1.2),))
    far = (partly, failed, hidden(scores=(), failed=()))
    met = graded(failed=(), points=4.0, scores=(score(statistic=1.1),))
    assert "≈" not in class_page([submission(tests=[test]) for test in (*far, met)])
    low = score(statistic=0.46, low=0.5, low_zero=0.1)
    for test in (near(), near(public=False), graded(failed=(), points=0.0, scores=(low,))):
        assert "≈" in class_page([submission(tests=[test])])


@pytest.mark.long
def test_the_table_is_sorted_by_the_heading_that_is_pressed(open_page, class_file):
    tab = open_page(class_file)
    assert names(tab) == ["<b>", "s1", "s10", "s2", "s3"]
    points = tab.locator("table.sortable th button", has_text="Points")
    points.click()
    assert names(tab) == ["s2", "s3", "<b>", "s10", "s1"]
    points.click()
    assert names(tab) == ["s1", "s10", "<b>", "s3", "s2"]
    assert tab.locator("th[aria-sort]").all_text_contents() == ["Points"]
    tab.locator("table.sortable th button", has_text="Submission").press("Enter")
    assert names(tab)[-4:] == ["s1", "s2", "s3", "s10"]
    # Similar programs stand side by side.
    tab.locator("summary", has_text="s1 and s2").click()
    left, right = tab.locator("details .pair pre").all()
    assert left.bounding_box()["x"] < right.bounding_box()["x"]
