"""A student's page and text: all of public tests, and of hidden ones points and sentence."""

import io
import re

import pytest
from PIL import Image

from graded_results import SECRET, FailedRun, graded, hidden, score, submission
from html_outline import Outline
from robsim.assignments import SubmissionResult
from robsim.assignments._reports import for_student, student_text, write_student
from robsim.assignments._reports.pages.class_page import class_page
from robsim.assignments._reports.pages.student import student_page


def png(color="red"):
    content = io.BytesIO()
    Image.new("RGB", (8, 8), color).save(content, "PNG")
    return content.getvalue()


@pytest.fixture
def page():
    return Outline(student_page(for_student(submission()), {"estimate": png()}))


def test_the_page_has_what_helps(page):
    for wanted in (
        *("s001", "A state estimator", "3.92 of 8 points", "2.92 of 4 points", "73 % of 4 points"),
        *("1.5 times", "up to 1.14", "from 3.2 on", "43 px off in step 33", "wrap the innovation"),
        *("1 of 10 runs", "estimate_state.py, line 23: ValueError: no covariance"),
        *("printed by me", "--only estimate", "plot.py is not used", "robsim 0.1.0"),
    ):
        assert wanted in page.text


def test_a_name_of_moodle_is_read_as_the_name_in_it():
    result = submission("Jané O'Doe_1042_assignsubmission_file_")
    for text in (student_page(result, {}), student_text(result), class_page([result])):
        assert "Jané O" in text
        assert "assignsubmission" not in text


def test_the_page_needs_no_other_file(page):
    assert page.names.count("img") == 1
    assert page.attributes("src")[0].startswith("data:image/png;base64,")
    assert all(link.startswith("#test-") for link in page.attributes("href"))
    assert not {"script", "link", "iframe", "object", "form", "base"} & set(page.names)
    assert any("default-src 'none'" in content for content in page.attributes("content"))


def test_the_page_can_be_read_without_seeing_it(page):
    assert page.attributes("lang") == ["en"]
    assert page.names.count("h1") == page.names.count("title") == 1
    assert page.attributes("alt") == ["Run 4, the worst. The estimate is 43 px off in step 33."]
    ids = page.attributes("id")
    assert len(ids) == len(set(ids)) == 2
    assert {link[1:] for link in page.attributes("href")} == set(ids)
    assert set(page.attributes("aria-labelledby")) == set(ids)


def test_of_hidden_tests_there_are_points_and_a_sentence_alone():
    seen = for_student(submission())
    texts = [
        student_page(seen, {"others": png(), "estimate": png()}),
        student_text(seen),
        seen.to_json(),
    ]
    for text in texts:
        assert SECRET not in text
        assert "4711" not in text
        assert "In other worlds" in text
        assert "Not as good there." in text
    assert texts[0].count("<img") == 1


def test_the_teachers_page_has_all(page):
    of_teacher = student_page(submission(), {"others": png()}, for_teacher=True)
    assert SECRET in of_teacher
    assert "--play others --run 4" in of_teacher
    # What has shut it in.
    assert "Landlock" in of_teacher
    assert "Landlock" not in page.text


def test_a_bar_has_limits_runs_and_result_in_their_places():
    test = graded(scores=(score(statistic=3.2, values=(2.0,) * 10, reference=(2.0,) * 10),))
    page = student_page(submission(tests=[test]), {})
    places = {
        kind: [float(x) for x in re.findall(rf'class="{kind}" style="left:([\d.]+)%', page)]
        for kind in ("mark", "run", "tick")
    }
    full, none = places["tick"]
    assert places["mark"] == [none]
    assert len(places["run"]) == 10
    assert 0 < places["run"][0] < full < none < 100


def test_a_bar_holds_any_number():
    for value in (float("nan"), float("inf"), 0.0, 1e300, -1.0):
        test = graded(scores=(score(statistic=value, values=(value,) * 2, reference=(value, 1.0)),))
        page = student_page(submission(tests=[test]), {})
        places = [float(x) for x in re.findall(r"(?:left|width):(-?[\d.]+)%", page)]
        assert places
        assert all(0 <= place <= 100 for place in places)


def test_where_the_grader_failed_no_points_are_shown():
    test = graded(status="error", whose="grader", points=0.0, most=3.0, scores=())
    result = submission(tests=[test, graded("second")])
    for text in (Outline(student_page(result, {})).text, student_text(result)):
        assert "3 of these 7 points" in text
        assert "0 of 3 points" not in text


def test_runs_that_failed_alike_are_told_together():
    place = {"slot": "control", "step": 3, "file": "control.py", "line": 7}
    failed = [FailedRun(run=run, reason="the same", **place) for run in (0, 2, 3)]
    failed.append(FailedRun(run=5, reason="no answer", slot="control"))
    lost = score(statistic=float("nan"), values=(), reference=(), fraction=0.0)
    result = submission(tests=[graded(failed=tuple(failed), scores=(lost,), worst=None)])
    for text in (Outline(student_page(result, {})).text, student_text(result)):
        assert text.count("the same") == 1
        assert "runs 0, 2, 3" in text
        assert "run 5" in text
        assert "error of the position" not in text  # of which there is nothing to say


def test_what_is_not_done_is_said():
    result = submission(tests=[graded(status="not run", points=0.0)], is_done=False)
    for text in (student_page(result, {}), student_text(result)):
        assert "not run" in text


def test_the_text_is_narrow_and_has_no_spaces_at_ends():
    lines = student_text(submission(notes=("word " * 100,))).split("\n")
    assert max(map(len, lines)) <= 88
    assert all(line == line.rstrip() for line in lines)


def test_all_files_of_a_submission_are_written(tmp_path):
    result = submission()
    write_student(tmp_path / "s001", result, pictures={"estimate": png(), "others": png("blue")})
    folder = tmp_path / "s001"
    assert sorted(file.name for file in folder.iterdir()) == sorted(
        ["index.html", "result.txt", "teacher.html", "result.json", "estimate.png", f"{SECRET}.png"]
    )
    assert SubmissionResult.from_json((folder / "result.json").read_text()) == result
    assert SECRET not in (folder / "index.html").read_text()
    assert (folder / "index.html").read_text().count("<img") == 1
    assert (folder / "teacher.html").read_text().count("<img") == 2


def test_pictures_of_before_are_shown_again(tmp_path):
    write_student(tmp_path, submission(), pictures={"estimate": png()})
    shown = (tmp_path / "index.html").read_text()
    later = graded("later", picture=None, status="failed")
    write_student(tmp_path, submission(tests=[graded(), hidden(), later]))
    again = (tmp_path / "index.html").read_text()
    assert shown.count("<img") == again.count("<img") == 1
