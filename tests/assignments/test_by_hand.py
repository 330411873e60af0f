"""Marks by hand, late days, hidden tests after a date: what of a class is not computed."""

import csv
import json
import shutil
import zipfile
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from graded_results import SECRET, reports, submission
from html_outline import Outline
from robsim.teach import (
    AssignmentError,
    ClassResult,
    LateRule,
    SubmissionResult,
    grade_class,
    grade_submission,
    load_assignment,
    pack_feedback,
    regrade_class,
)
from robsim.teach.assignments.classes import plan
from small_assignments import TESTS, assignment, drawn_quickly, solution

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():
        yield


@pytest.fixture
def hw3(graded_class):
    """Its assignment, with points for style, and days that cost something."""
    late = LateRule(per_day=0.1, free_days=1, most_days=4)
    return replace(graded_class.assignment, by_hand={"style": 2.0}, late=late)


@pytest.fixture
def out(graded_class, tmp_path):
    return shutil.copytree(graded_class.out, tmp_path / "out")


def rows_of(file, encoding="utf-8-sig", delimiter=","):
    return list(csv.reader(file.read_text(encoding).splitlines(), delimiter=delimiter))


def marks_in(out):
    with (out / "class.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def wrong(out, text, *calls):
    """Return the error of calls with a table, which write nothing."""
    before = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    (out / "by_hand.csv").write_text(text)
    before[out / "by_hand.csv"] = text.encode()
    told = []
    for call in calls:
        with pytest.raises(AssignmentError) as caught:
            call()
        told.append(str(caught.value))
    assert {file: file.read_bytes() for file in out.rglob("*") if file.is_file()} == before
    assert len(set(told)) == 1
    return told[0]


TABLE = """style;student;comment;points;late_days
1,5;s001;"Read; ""well""

twice";;
2;s002;Ein Versehen bei der Abgabe: größer;5,5;3
"""


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_what_a_teacher_writes_lives_on_in_all_tables_and_pages(
    graded_class, hw3, out, tmp_path, ran, encoding
):
    subs, table = tmp_path / "subs", out / "by_hand.csv"
    assert rows_of(table)[0] == ["student", "late_days", "points", "comment"]
    assert [row[0] for row in rows_of(table)] == ["student", "s001", "s002", "s003"]
    table.write_text(TABLE.replace(";", "\t") if encoding == "utf-16" else TABLE, encoding)
    solution(subs / "s004", "naive")
    for student in ("s001", "s002", "s003"):
        shutil.copytree(graded_class.submissions / student, subs / student)
    before = {one.student: one.points for one in graded_class.result.results}
    # Of 8 points; three days take a fifth.
    expected = {"s001": before["s001"] + 1.5, "s002": 0.8 * 7.5, "s003": before["s003"]}

    anew = regrade_class(hw3, out, columns="moodle", teacher_pages=True)
    assert {one.student: one.points for one in anew.results} == expected
    assert anew.changes == {name: (before[name], expected[name]) for name in ("s001", "s002")}
    assert regrade_class(hw3, out, columns="moodle").changes == {}
    moodle = marks_in(out)[1]
    assert (moodle["Grade"], moodle["Maximum grade"]) == ("6", "8")
    result = grade_class(hw3, subs, out)
    assert ran == [("s004", "shown"), ("s004", "hidden")]
    assert {one.student: one.points for one in result.results if one.student != "s004"} == expected
    robsim = marks_in(out)[1]
    assert (robsim["points"], robsim["most"], robsim["style"]) == ("6", "8", "2")
    files = [out / "s002" / name for name in ("result.txt", "index.html", "teacher.html")]
    texts = [Outline(file.read_text("utf-8")).text for file in files]
    of_tests = f"{before['s002']:.2f}".rstrip("0").rstrip(".")
    for text in (*texts, moodle["Feedback comments"], robsim["notes"], str(result)):
        said = " ".join(text.split())
        for wanted in (
            "größer",
            f"5.5 points instead of {of_tests} of the tests",
            "3 days late",
            "20 %",
        ):
            assert wanted in said
    for text in texts:
        assert "6 of 8" in " ".join(text.split())
        assert "--only style" not in text  # there is nothing to repeat
        assert "✎ by hand" in text or "✎ Style: by hand" in text
    page = (out / "class.html").read_text("utf-8")
    assert ">6</b>" in page
    assert "not run" not in (out / "s003/result.txt").read_text("utf-8")
    assert any("größer" in title for title in Outline(page).attributes("title"))
    read = SubmissionResult.from_json((out / "s002/result.json").read_text())
    assert (read.points, read.points_of_tests) == (6, before["s002"])
    for columns in ("canvas", "blackboard"):
        assert '"6"' in reports.marks_table(result.results, columns=columns)
    # A student was added; the teacher's cells are as they were.
    kept = rows_of(table, encoding, "\t" if encoding == "utf-16" else ";")
    assert kept[0] == ["style", "student", "comment", "points", "late_days"]
    assert "größer" in kept[-3][2]
    assert [row[:2] for row in kept[-2:]] == [["", "s003"], ["", "s004"]]
    assert table.read_text(encoding).startswith(("style;student", "style\tstudent"))


def test_all_faults_of_the_table_are_told_before_anything_is_written(graded_class, hw3, out, ran):
    def grade():
        return grade_class(hw3, graded_class.submissions, out)

    def regrade():
        return regrade_class(hw3, out)

    text = (
        "student,late_days,points,comment,style\ns001,-1,7,,2.5\ns01,,,,\ns002,two,,,\ns002,,,,\n"
    )
    told = wrong(out, text, grade, regrade)
    for part in ("s001: late_days", "s001: points", "s001: style", "'s01'; did you mean 's001'?"):
        assert part in told
    for part in ("s002: late_days must be a number, got 'two'", "s002 has 2 rows"):
        assert part in told
    for text, part in {
        "student,coment\n": "'coment'; did you mean 'comment'?",
        "late_days,late_days\n": "the column student is missing; duplicate column late_days",
        "student,comment\ns001,well, but late\n": "quotes",
    }.items():
        assert part in wrong(out, text, grade, regrade)
    (out / "by_hand.csv").write_bytes("student\nMüller\n".encode("latin-1"))
    with pytest.raises(AssignmentError, match="UTF-8"):
        grade()
    without = replace(hw3, late=None)
    assert "[late]" in wrong(
        out, "student,late_days\ns001,1\n", lambda: regrade_class(without, out)
    )
    assert ran == []


def test_a_submission_alone_has_its_marks_by_hand_where_there_is_a_table(
    graded_class, hw3, out, tmp_path
):
    (out / "by_hand.csv").write_text("student,points\ns001,1\n")
    one = grade_submission(hw3, graded_class.submissions / "s001", out)
    assert (one.points, one.most) == (1, 8)
    again = shutil.copytree(out, tmp_path / "alone")
    (again / "by_hand.csv").unlink()
    alone = grade_submission(hw3, graded_class.submissions / "s001", again)
    assert (alone.points, alone.most) == (6, 6)
    assert not (again / "by_hand.csv").exists()


@pytest.mark.parametrize(
    ("rule", "days", "kept"),
    [
        (LateRule(per_day=0.3, free_days=1), (1, 1.5, 4), (1, 0.85, 0.1)),
        (LateRule(per_day=0.3, free_days=1), (5, 0, 2), (0, 1, 0.7)),
        (LateRule(per_day=0, most_days=2), (2, 2.5, 99), (1, 0, 0)),
    ],
)
def test_days_take_their_share_until_there_is_none(hw3, out, rule, days, kept):
    lines = [f"s00{number},{one}\n" for number, one in enumerate(days, 1)]
    (out / "by_hand.csv").write_text(f"student,late_days\n{''.join(lines)}")
    anew = regrade_class(replace(hw3, late=rule), out)
    assert [one.by_hand.kept for one in anew.results] == pytest.approx(kept)
    for one in anew.results:
        assert one.points == round(one.points_of_tests * one.by_hand.kept, 2)


def test_the_keys_are_read_and_refused(tmp_path):
    def loaded(text, more=""):
        return load_assignment(assignment(tmp_path / "hw3", f"{text}\n{TESTS}\n{more}"))

    more = "[late]\nper_day = 0.2\nmost_days = 3\n[by_hand]\nstyle = 2\nreport = 5.5\n"
    hw3 = loaded('hidden_from = 2026-12-01\nleaderboard = "shown.heading"', more)
    assert hw3.late == LateRule(per_day=0.2, most_days=3)
    assert hw3.by_hand == {"style": 2, "report": 5.5}
    assert hw3.leaderboard == "shown.heading"
    local = datetime(2026, 12, 1).astimezone()
    assert hw3.hidden_from == local
    assert loaded("hidden_from = 2026-12-01T00:00:00").hidden_from == local
    given = loaded("hidden_from = 2026-12-01T00:00:00+05:00").hidden_from
    assert given == datetime(2026, 11, 30, 19, tzinfo=UTC)
    for named, (text, more) in {
        "hidden_from": ("hidden_from = 3", ""),
        "'hidden.heading'": ('leaderboard = "hidden.heading"', ""),
        "per_day": ("", "[late]\nper_day = 2\n"),
        "per_day is missing": ("", "[late]\nfree_days = 2\n"),
        "points": ("", "[by_hand]\npoints = 2\n"),
        "style": ("", "[by_hand]\nstyle = -2\n"),
    }.items():
        with pytest.raises(AssignmentError, match=named):
            loaded(text, more)
    with pytest.raises(AssignmentError, match="shown"):
        grade_submission(loaded("", "[by_hand]\nshown = 1\n"), solution(tmp_path / "s001"))


def test_hidden_tests_are_run_from_their_time_on(hw3, tmp_path, monkeypatch, ran):
    start = datetime(2031, 5, 1, 8, 30, tzinfo=UTC)
    clock = start - timedelta(seconds=1)
    monkeypatch.setattr(plan, "now", lambda: clock)
    hw3, mine, file = replace(hw3, hidden_from=start), solution(tmp_path / "s001"), tmp_path / "r"
    early = grade_submission(hw3, mine, tmp_path / "out", gradescope=file)
    assert ran == [("s001", "shown")]
    assert (early.points, early.is_done, early.has_errors) == (2, False, False)
    result = ClassResult(name="hw3", results=(early,))
    told = json.loads(file.read_text())
    shown, hidden = told["tests"]
    assert shown["score"] == 2
    assert not {"score", "status"} & set(hidden)
    texts = [(tmp_path / "out/s001" / name).read_text() for name in ("index.html", "result.txt")]
    for text in (
        *texts,
        told["output"],
        str(result),
        reports.marks_table([early], columns="moodle"),
    ):
        assert "2031-05-01 08:30 UTC" in " ".join(text.split())
    (row,) = csv.DictReader(reports.marks_table([early]).splitlines())
    assert (row["hidden"], row["is_done"]) == ("", "no")
    grade_submission(hw3, mine, only="hidden")
    assert ran == [("s001", "shown")]
    clock = start
    late = grade_submission(hw3, mine, tmp_path / "out")
    assert ran == [("s001", "shown"), ("s001", "hidden")]
    assert (late.points, late.is_done) == (6, True)


def test_results_of_before_are_read():
    data = json.loads(submission().to_json())
    for name in ("by_hand", "command"):
        del data[name]
    for test in data["tests"]:
        del test["by_hand"]
    assert SubmissionResult.from_json(json.dumps(data)) == submission()


def by_moodle(path):
    """Whose a file in a zip of feedback is, and its name there, as Moodle's importer decides."""
    parts = path.split("/")
    while parts:
        _, *rest = parts.pop(0).split("_", 4)
        if len(rest) >= 3 and rest[0].isdigit() and rest[1:3] == ["assignsubmission", "file"]:
            return rest[0], "/".join([*rest[3:], *parts]).lstrip("/")
    return None


def test_students_get_their_pages_as_moodle_takes_them(tmp_path):
    names = ("Zoë Åström_1042_assignsubmission_file", "Jo Do_77_assignsubmission_file_hw3", "kim")
    strange = [
        f"{name}_assignsubmission_file" for name in ("Bo \u202eX_81", "a_3_82", "?" * 99 + "_83")
    ]
    results = tuple(map(submission, [*names, *strange]))
    team = tuple(f"{name}_assignsubmission_file" for name in ("Al Do_5", "Bo Do_6"))
    results += (submission("../a"), replace(submission("team"), members=team))
    for result in results:
        place = tmp_path / reports.writing.folder_name(result.student)
        reports.write_student(place, result, teacher_page=True)
    graded = ClassResult(name="hw3", results=results)
    with pytest.warns(UserWarning, match="kim"):  # others are named as Moodle does
        pack_feedback(graded, tmp_path, tmp_path / "feedback.zip")
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        contents = {name: archive.read(name).decode() for name in archive.namelist()}
    files = ("index.html", "result.txt")
    assert {by_moodle(name) or name for name in contents} == {
        *(
            (number, file)
            for number in ("1042", "77", "81", "82", "83", "5", "6")
            for file in files
        ),
        *(
            f"{name}/{file}"
            for file in files
            for name in ("kim", reports.writing.folder_name("../a"))
        ),
    }
    assert not any(SECRET in content for content in contents.values())
    assert "Zoë" in contents["Zoë Åström_1042_assignsubmission_file_/result.txt"]
    group = replace(results[2], members=names[:2])
    pack_feedback(replace(graded, results=(group,)), tmp_path, tmp_path / "feedback.zip")
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        found = {by_moodle(name) for name in archive.namelist()}
    assert found == {(number, file) for number in ("1042", "77") for file in files}
