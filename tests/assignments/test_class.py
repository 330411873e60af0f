"""A class is graded: whatever its submissions do, and wherever it is ended."""

import csv
import json
import os
import re
import shutil
import signal
import sys
import warnings
import zipfile
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from inspect import getsource
from pathlib import Path
from urllib.parse import unquote

import pytest

from clusters import local_cluster
from robsim.estimation.reference import kalman
from robsim.teach import (
    AssignmentError,
    ScoreLimit,
    SubmissionResult,
    grade_class,
    grade_submission,
    load_assignment,
    pack_feedback,
    regrade_class,
)
from robsim.teach.assignments.classes import progress
from robsim.teach.reports.writing import folder_name
from small_assignments import LIMITS, TESTS, assignment, drawn_quickly, solution
from submissions import notebook, packed
from waiting import wait_for

HOSTILE = {
    "exits": "import os\ndef estimate_state(step):\n    os._exit(0)\n",
    "hangs": "while True:\n    pass\n",
    "floods": "def estimate_state(step):\n    while True:\n        print('x' * 10**6)\n",
    "kills": "import os, signal\ndef estimate_state(step):\n    os.kill(os.getppid(), 9)\n",
}
STRICT = {name: ScoreLimit(full=0.5, zero=1.5) for name in LIMITS}

pytestmark = pytest.mark.long


@pytest.fixture(autouse=True)
def quickly():
    with drawn_quickly():  # where this process grades
        yield


@pytest.fixture
def hw3(graded_class):
    return graded_class.assignment


@pytest.fixture
def folders(graded_class, tmp_path):
    """Copies of the submissions of a class that was graded, and of what came of them."""
    subs = shutil.copytree(graded_class.submissions, tmp_path / "subs")
    return subs, shutil.copytree(graded_class.out, tmp_path / "out")


def result_of(out, student):
    return SubmissionResult.from_json((out / student / "result.json").read_text())


@pytest.mark.slow
def test_hostile_submissions_do_not_keep_others_from_their_points(tmp_path):
    quick = "limits = { call = 5.0, first_call = 10.0 }\n"
    once = TESTS.replace("runs = 2", "runs = 1")
    hw3 = load_assignment(assignment(tmp_path / "hw3", quick + once))
    subs = tmp_path / "subs"
    for student in ("s001", "s003"):
        solution(subs / student)
    for name, text in HOSTILE.items():
        (subs / name).mkdir()
        (subs / name / "estimate_state.py").write_text(text)
    (subs / "s002.zip").write_bytes(b"no zip")
    (subs / ".DS_Store").write_bytes(b"left by a tool")
    hw3 = replace(hw3, tests=hw3.tests[:1])
    result = grade_class(hw3, subs, tmp_path / "out", executor=2)
    points = {one.student: one.points for one in result.results}
    assert points == {"s001": 2, "s003": 2, "s002": 0} | dict.fromkeys(HOSTILE, 0)
    assert not result.has_errors
    assert not result.is_full
    assert [one.student for one in result.results] == sorted(points)
    for student in points:
        assert result_of(tmp_path / "out", student).is_done
        assert (tmp_path / "out" / student / "index.html").exists()
    assert (tmp_path / "out/class.html").exists()


def test_a_notebook_with_a_star_import_has_its_points_and_the_cells_that_count(hw3, tmp_path):
    """The names of ``import *`` are not in the notebook, and were lost in silence."""
    folder = solution(tmp_path / "s010")
    (folder / "estimate_state.py").rename(folder / "mine.py")
    fills = "sim.estimate_state = lambda step: estimate_state(step)"
    notebook(folder / "hw3.ipynb", "from mine import *", "sim.run(9)", fills)
    result = grade_submission(hw3, folder, out=tmp_path / "out")
    assert result.points == result.most
    for name in ("index.html", "result.txt"):
        (page,) = (tmp_path / "out").rglob(name)
        assert "hw3.ipynb: these cells count: 1, 3" in page.read_text()


def test_copies_of_solutions_and_of_earlier_years_are_named(hw3, folders):
    subs, out = folders
    earlier = hw3.folder / "earlier"
    shutil.copytree(subs / "s003", earlier / "2025/anna")
    shutil.copy(subs / "s003/estimate_state.py", earlier / "ben.py")
    source = (subs / "s003/estimate_state.py").read_text()
    moodle = {f"{name}_1_assignsubmission_file/a.py": source for name in ("cy", "zoltan")}
    packed(earlier / "2024.zip", moodle)
    (earlier / "broken.zip").write_bytes(b"no zip")
    pasted = getsource(kalman).replace("self._", "self.")
    (subs / "pasted.py").write_text(f"{pasted}\nestimate_state = ExtendedKalmanFilter()\n")
    try:
        grade_class(hw3, subs, out)
        text = (out / "class.html").read_text()
        grade_class(hw3, subs, out, pseudonyms=True)
    finally:
        shutil.rmtree(earlier)
    assert "s003, earlier: 2024.zip/cy, earlier: 2024.zip/zoltan, earlier: 2025/anna" in text
    assert "earlier: 2025/anna, earlier: ben" in text
    assert "s001, shipped solution estimate/reference" in text
    assert "pasted and robsim/estimation.reference" in text
    assert not re.search("anna|zoltan|s003", (out / "class.html").read_text())
    regrade_class(hw3, out)  # which reads no programs
    assert (out / "class.html").read_text() == text


def test_archives_that_are_not_read_have_a_row_and_a_sentence(hw3, tmp_path):
    files = {"s001": "s001.rar", "s002": "s002.7z", "s003": "s003.TGZ", "s004.tar": "s004.tar.gz"}
    (tmp_path / "subs").mkdir()
    for name in files.values():
        (tmp_path / "subs" / name).write_bytes(b"Rar!")
    result = grade_class(hw3, tmp_path / "subs", tmp_path / "out")
    assert {one.student: one.points for one in result.results} == dict.fromkeys(files, 0)
    for one in result.results:
        assert files[one.student] in one.tests[0].sentence
        assert one.student in (tmp_path / "out/class.html").read_text()


@pytest.mark.parametrize(
    "executor",
    [
        "threads",
        *(pytest.param(one, marks=pytest.mark.slow) for one in (2, ThreadPoolExecutor, "cluster")),
    ],
)
def test_the_results_are_the_same_wherever_they_are_computed(graded_class, tmp_path, executor):
    def grade(executor):
        subs = graded_class.submissions
        return grade_class(graded_class.assignment, subs, tmp_path / "out", executor=executor)

    if executor == "cluster":
        with local_cluster(tmp_path) as client:
            result = grade(client)
    elif isinstance(executor, type):
        with executor(2) as pool:
            result = grade(pool)
    else:
        result = grade(executor)
    for one, other in zip(result.results, graded_class.result.results, strict=True):
        assert one.student == other.student
        for test, same in zip(one.tests, other.tests, strict=True):
            assert (test.points, test.sentence) == (same.points, same.sentence)
            assert repr(test.scores) == repr(same.scores)  # there are NaN among them


def test_what_is_done_is_not_done_again(graded_class, folders, ran):
    subs, out = folders
    hw3 = graded_class.assignment
    assert repr(grade_class(hw3, subs, out)) == repr(graded_class.result)
    assert ran == []
    (subs / "s003/estimate_state.py").write_text("def estimate_state(step):\n    return None\n")
    shutil.copytree(subs / "s001", subs / "s004")
    (out / "s002/result.json").write_text("[" * 100_000)  # cannot be read
    result = grade_class(hw3, subs, out)
    assert ran == [(s, test) for s in ("s002", "s003", "s004") for test in ("shown", "hidden")]
    assert [one.is_done for one in result.results] == [True] * 4
    json.loads((out / "s002/result.json").read_text())
    shown, hidden = hw3.tests
    noisier = replace(hidden, task=replace(hidden.task, noise=14.0))
    del ran[:]
    grade_class(replace(hw3, tests=(shown, noisier)), subs, out)
    assert ran == [(student, "hidden") for student in ("s001", "s002", "s003", "s004")]


def test_all_students_with_two_submissions_or_one_folder_are_told_before_anything_is_graded(
    hw3, folders, ran, tmp_path
):
    subs, _ = folders
    for name in ("s001.py", "s002.zip", "Zoe\u0308.py", "Zo\u00eb.zip", "ann.py", "Ann.zip"):
        (subs / name).touch()
    with pytest.raises(AssignmentError) as caught:
        grade_class(hw3, subs, tmp_path / "new")
    for told in ("s001.py, s001/", "s002.zip, s002/", "of Zo\u00eb", "Ann, ann"):
        assert told in str(caught.value)
    assert ran == []
    assert not (tmp_path / "new").exists()


def test_files_that_are_no_submissions_and_strange_names_stop_no_class(hw3, folders, tmp_path):
    subs, _ = folders
    (subs / "s001").rename(subs / "class.csv")
    shutil.rmtree(subs / "s003")
    strange = {"con", "dot.", "a\\tb", "\ufeffx", "g\\u202eh", "\u00fc" * 125}
    for name in ("Thumbs.db", "grades.xlsx", "readme.txt", "a\tb.rar", "g\u202eh.rar"):
        (subs / name).touch()
    for name in strange - {"a\\tb", "g\\u202eh"}:
        (subs / f"{name}.7z").touch()
    with (
        pytest.warns(UserWarning, match=r"Thumbs\.db, grades\.xlsx, readme\.txt"),
        pytest.warns(UserWarning, match=r"class\.csv in "),
    ):
        result = grade_class(hw3, subs, tmp_path / "new")
    assert {one.student for one in result.results} == {"class.csv", "s002", *strange}
    assert "class.csv" in (tmp_path / "new/class.csv").read_text()
    page = (tmp_path / "new/class.html").read_text()
    links = [unquote(link) for link in re.findall('href="([^"#]+/[^"]*)"', page)]
    assert len(set(links)) == len(result.results)
    for link in links:
        assert (tmp_path / "new" / link).is_file()
        assert re.fullmatch(r"[\w ()-]{1,100}", link.partition("/")[0])
    assert repr(regrade_class(hw3, tmp_path / "new").results) == repr(
        tuple(sorted(result.results, key=lambda one: folder_name(one.student)))
    )


# --- downloads of learning platforms

NOTHING = "it has "  # precedes the names of files without a slot


def graded(assignment, submissions, out):
    """The sentence of each student, from the names of files on, and the warnings."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        result = grade_class(assignment, submissions, out)
    told = {one.student: one.tests[0].sentence.rpartition(NOTHING)[2] for one in result.results}
    return told, " ".join(str(one.message) for one in warned)


def without_flags(path):
    """A zip whose names are not said to be UTF-8, as some tools write them."""
    content = bytearray(path.read_bytes())
    for sign, place in ((b"PK\x01\x02", 9), (b"PK\x03\x04", 7)):
        for found in re.finditer(sign, content):
            content[found.start() + place] &= 0xF7
    path.write_bytes(content)
    return path


def test_a_download_of_moodle_is_a_class_as_it_comes(hw3, tmp_path, ran):
    moodle, text = "{}_assignsubmission_file", "{}_assignsubmission_onlinetext"
    inner = packed(tmp_path / "in.zip", {"hw/right.txt": "x"}).read_bytes()
    twice = packed(tmp_path / "twice.zip", {"in.zip": inner}).read_bytes()
    bomb = packed(tmp_path / "bomb.zip", {"estimate_state.py": "#" * 900_000}).read_bytes()
    link = zipfile.ZipInfo(f"{moodle.format('Lo_8')}/estimate_state.py")
    link.external_attr = 0o120777 << 16
    files = {
        f"{moodle.format('Zoë_1')}/hw.zip": inner,
        f"{text.format('Zoë_1')}/onlinetext.html": "x",
        f"{text.format('Ben_2')}/onlinetext.html": "x",
        f"{moodle.format('Cy_3')}_a.py": "x = 1",
        f"{moodle.format('Cy_3')}_b.txt": "x",
        f"{moodle.format('Dora_4')}/bomb.zip": bomb,
        f"{moodle.format('Emil_5')}/twice.zip": twice,
        f"{moodle.format('Fay_6')}/../../up.py": "x",
        f"{moodle.format('Gus_7')}\\old.txt": "x",
        link: "/etc/passwd",
        f"{moodle.format('Mia_9')}/": "",
        "__MACOSX/._x": "x",
        "Thumbs.db": "x",
    }
    path = without_flags(packed(tmp_path / "moodle.zip", files))
    told, warned = graded(hw3, path, tmp_path / "out")
    names = {name.split("_")[0]: sentence for name, sentence in told.items()}
    parts = {"Zoë": "right.txt", "Ben": "onlinetext.html", "Cy": "a.py", "Dora": "larger"}
    parts |= {
        "Emil": "archive",
        "Fay": "leads out",
        "Gus": "old.txt",
        "Lo": "link",
        "Mia": "is empty",
    }
    assert names.keys() == parts.keys()
    for name, part in parts.items():
        assert part in names[name]
    assert "Thumbs.db, Zoë_1_assignsubmission_onlinetext/" in warned
    assert ran == []
    assert not list(tmp_path.rglob("up.py"))


def test_no_name_of_a_student_in_moodle_loses_a_submission(hw3, tmp_path, ran):
    names = (".Ann_1", "__Ben_2", "Team/Cy_3", "Team/Dora_4", '=Emil, "E" _5')
    files = {f"{name}_assignsubmission_file/{name[-1]}.txt": "x" for name in names}
    told, warned = graded(hw3, packed(tmp_path / "moodle.zip", files), tmp_path / "out")
    students = [f"{name.replace('/', ' ')}_assignsubmission_file" for name in names]
    assert told == {
        student: f"{name[-1]}.txt" for student, name in zip(students, names, strict=True)
    }
    assert f"{students[-1]} in {folder_name(students[-1])}" in warned


def test_a_zip_of_moodle_and_its_folders_have_the_same_limits(hw3, tmp_path, ran):
    files = {f"Ann_1_assignsubmission_file/{name}.txt": name * 900_000 for name in "xy"}
    path = packed(tmp_path / "moodle.zip", files)
    told, _ = graded(hw3, path, tmp_path / "out")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "class")
    assert told == {"Ann_1_assignsubmission_file": "x.txt, y.txt"}
    assert graded(hw3, tmp_path / "class", tmp_path / "out")[0] == told


def test_attempts_and_files_of_canvas_and_blackboard_are_those_of_a_student(hw3, tmp_path, ran):
    at = "hw3_{}_attempt_2026-11-0{}-10-11-12"
    files = {
        "anna_LATE_12_34_a.txt": "x",
        "anna_12_35_a-1.py": "x = 1",
        "ben_13_36_essay.pdf": "x",
        f"{at.format('cy', 1)}_old.py": "x = 1",
        f"{at.format('cy', 2)}_new.zip": packed(tmp_path / "new.zip", {"b.txt": "x"}).read_bytes(),
        f"{at.format('cy', 2)}.txt": "x",
        f"{at.format('d_e', 2)}_a.py": "x = 1",
    }
    told, warned = graded(hw3, packed(tmp_path / "class.zip", files), tmp_path / "out")
    assert told.keys() == {"anna_12", "cy", "d_e"}
    assert "a.py" in told["anna_12"]
    assert told["cy"] == "b.txt"
    for left in ("essay.pdf", "-12.txt", "old.py"):
        assert left in warned
    with zipfile.ZipFile(tmp_path / "class.zip") as archive:
        archive.extractall(tmp_path / "subs")
    assert graded(hw3, tmp_path / "subs", tmp_path / "out2")[0] == told


def test_the_contents_of_a_zip_are_listed_once_for_all_students(hw3, tmp_path, monkeypatch):
    listed = []

    class Listed(zipfile.ZipFile):
        def __init__(self, file, *args):
            listed.append(Path(getattr(file, "name", "")).name)
            super().__init__(file, *args)

    files = {f"{name}_{len(name)}_assignsubmission_file/a.txt": "x" for name in ("al", "ben")}
    path = packed(tmp_path / "class.zip", files)
    monkeypatch.setattr(zipfile, "ZipFile", Listed)
    told, _ = graded(hw3, path, tmp_path / "out")
    assert (len(told), listed) == (2, ["class.zip"])
    graded(hw3, path, tmp_path / "out")  # nothing of before is kept
    assert listed == ["class.zip"] * 2


@pytest.mark.parametrize(
    ("own", "name", "other"),
    [
        ("hw_eve_attempt_2026-11-01-10-11-12", "x_cy_attempt_2099-11-01-10-11-12_a.py", "cy"),
        ("Eve_9_assignsubmission_file", "Cy_5_assignsubmission_file_a.py", "Participant 5"),
    ],
)
def test_the_name_of_a_file_makes_it_no_other_students(hw3, tmp_path, own, name, other):
    theirs = own.replace("eve", "cy").replace("Eve_9", "Cy_5")
    files = {f"{own}_{name}": "x = 1", f"{theirs}_a.py": "y = 1"}
    told, _ = graded(hw3, packed(tmp_path / "class.zip", files), tmp_path / "out")
    assert sorted(name.lower().partition("_")[0] for name in told) == ["cy", "eve"]
    kind = "moodle" if "Eve" in own else "blackboard"
    result = regrade_class(hw3, tmp_path / "out", columns=kind)
    table = (tmp_path / "out/class.csv").read_text()
    assert table.count(other) == 1
    pack_feedback(result, tmp_path / "out", tmp_path / "feedback.zip")
    with zipfile.ZipFile(tmp_path / "feedback.zip") as archive:
        assert len({*archive.namelist()}) == 4


def test_names_with_other_spaces_or_quotes_share_no_row(hw3, tmp_path):
    for name in (" ann.py", "ann .zip"):
        (tmp_path / "subs").mkdir(exist_ok=True)
        (tmp_path / "subs" / name).touch()
    with pytest.raises(AssignmentError, match="ann"):
        grade_class(hw3, tmp_path / "subs", tmp_path / "out")
    (tmp_path / "subs/ann .zip").unlink()
    for name in ("=x.py", "'=x.py", " .py"):
        (tmp_path / "subs" / name).touch()
    for _ in range(2):
        grade_class(hw3, tmp_path / "subs", tmp_path / "out")
    rows = (tmp_path / "out/by_hand.csv").read_text().splitlines()
    assert len(rows) == len(set(rows)) == 5


def test_a_full_disk_of_the_grader_costs_nobody_points(hw3, tmp_path, monkeypatch):
    text = "def estimate_state(step):\n    raise OSError(28, 'No space left on device')\n"
    (tmp_path / "estimate_state.py").write_text(text)

    def statuses():
        result = grade_submission(hw3, tmp_path / "estimate_state.py", tmp_path / "out")
        return {(test.status, test.whose) for test in result.tests}

    usage = shutil.disk_usage(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(shutil, "disk_usage", lambda path: usage._replace(free=8192))
        assert statuses() == {("error", "grader")}
    assert statuses() == {("failed", "submission")}  # it is run again


# --- groups, and students again


def columns_of(file, *names):
    with file.open(newline="") as table:
        return [tuple(row[name] for name in names) for row in csv.DictReader(table)]


def test_the_members_of_a_group_get_its_marks(hw3, tmp_path):
    out, subs = tmp_path / "out", tmp_path / "subs"
    subs.mkdir()
    for name in ("g1", "ben", "dora"):
        packed(subs / f"{name}.zip", {f"{name}.txt": "x"})
    table = "\ufeffNo;Student;Group\n1;anna;g1\n2;cy;g1\n3;ben;g2\n4;emil;g2\n5;fay;g3\n"
    (subs / "groups.csv").write_text(table, encoding="utf-16")
    told, warned = graded(hw3, subs, out)
    assert told == {"g1": "g1.txt", "g2": "ben.txt", "dora": "dora.txt"}
    assert "g3" in warned
    assert "dora" in warned
    students = [("dora",), ("anna",), ("cy",), ("ben",), ("emil",)]
    assert columns_of(out / "class.csv", "student") == students
    assert "g1 (anna, cy)" in (out / "class.html").read_text()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        regrade_class(hw3, out, columns="canvas")
    assert columns_of(out / "class.csv", "SIS Login ID")[1:] == students
    packed(subs / "cy.zip", {"x.txt": "x"})
    with pytest.raises(AssignmentError, match="group g1, cy, g1"):
        graded(hw3, subs, out)
    other = tmp_path / "other.csv"
    long = f"group,student\na,{'x' * 200_000}\n"
    twice = "group,student\na,cy\nb,cy\n"
    for text, named in ((twice, "cy"), ("grp,student\n", "no group"), (long, "other.csv.*field")):
        other.write_text(text)
        with pytest.raises(ValueError, match=named):
            grade_class(hw3, subs, out, groups=other)


def test_no_member_of_a_group_loses_a_mark_to_one_of_the_same_name(hw3, tmp_path):
    names = ("Ann_1_assignsubmission_file", "Ann_7_assignsubmission_file")
    files = {f"{name}/a.txt": "x" for name in names}
    packed(tmp_path / "class.zip", files | {"Cy_3_assignsubmission_file/b.txt": "x"})
    (tmp_path / "groups.csv").write_text("group,student\nteam,Ann\n")
    with pytest.warns(UserWarning, match="Cy"):
        result = grade_class(hw3, tmp_path / "class.zip", tmp_path / "out")
    assert [one.members for one in result.results if one.student == "team"] == [names]
    (tmp_path / "groups.csv").unlink()
    with pytest.raises(ValueError, match=f"only.*Ann.*{names[0]}, {names[1]}"):
        grade_class(hw3, tmp_path / "class.zip", tmp_path / "new", only="Ann")


def test_a_member_who_handed_in_nothing_has_a_number_in_moodle_by_its_worksheet(hw3, tmp_path):
    sheet = (
        "Identifier,Full name,Grade,Group\n"
        "Participant 1,Ann O'Do,,team\nParticipant 7,Ben,,team\nParticipant 8,Ann O'Do,,\n"
    )
    (tmp_path / "groups.csv").write_text(sheet)
    name = "{}_{}_assignsubmission_file"
    files = {f"{name.format('Ann ODo', number)}/a.txt": "x" for number in (1, 8)}
    out, feedback = tmp_path / "out", tmp_path / "feedback.zip"
    with pytest.warns(UserWarning, match="alone.*Ann ODo_8"):
        result = grade_class(hw3, packed(tmp_path / "m.zip", files), out, columns="moodle")
    members = (name.format("Ann ODo", 1), name.format("Ben", 7))
    assert [one.members for one in result.results] == [(), members]
    identifiers = columns_of(out / "class.csv", "Identifier")
    assert identifiers == [("Participant 8",), ("Participant 1",), ("Participant 7",)]
    pack_feedback(result, out, feedback)  # no warning: Moodle knows all of them
    with zipfile.ZipFile(feedback) as archive:
        folders = {path.partition("/")[0] for path in archive.namelist()}
    assert folders == {f"{one}_" for one in (*members, name.format("Ann ODo", 8))}


def test_a_group_of_moodle_hands_in_once(hw3, tmp_path):
    names = {"G 3-Anna_1": "a", "G 3-Ben_2": "a", "Jo-Lee_3": "b", "Jo-Ann_4": "c"}
    names |= {"T-1-Cy_5": "d", "T-1-Di-Ann_6": "d", "T-2-Ed_7": "e", "T-2-Fay_8": "e"}
    files = {f"{name}_assignsubmission_file/{file}.txt": "x" for name, file in names.items()}
    path = packed(tmp_path / "moodle.zip", files)
    with pytest.warns(UserWarning, match="same files: G 3, T-1, T-2$"):
        grade_class(hw3, path, tmp_path / "out", columns="moodle")
    assert columns_of(tmp_path / "out/class.csv", "Identifier", "Full name") == [
        ("Participant 1", "Anna"),
        ("Participant 2", "Ben"),
        ("Participant 4", "Jo-Ann"),
        ("Participant 3", "Jo-Lee"),
        ("Participant 5", "Cy"),
        ("Participant 6", "Di-Ann"),
        ("Participant 7", "Ed"),
        ("Participant 8", "Fay"),
    ]


def test_equal_files_are_no_group_in_a_class_without_groups(hw3, tmp_path):
    files = {
        f"{name}_assignsubmission_file/a.txt": "x" for name in ("Jo-Lee_1", "Jo-Ann_2", "Al_3")
    }
    told, _ = graded(hw3, packed(tmp_path / "moodle.zip", files), tmp_path / "out")
    assert len(told) == 3


def test_a_student_is_graded_again_without_the_others(hw3, folders, ran):
    subs, out = folders
    before = columns_of(out / "class.csv", "student", "points")
    for student in ("s001", "s002"):
        shutil.copy(subs / "s003/estimate_state.py", subs / student / "estimate_state.py")
    result = grade_class(hw3, subs, out, only="s002")
    assert ran == [("s002", "shown"), ("s002", "hidden")]
    after = columns_of(out / "class.csv", "student", "points")
    assert after == [(one.student, f"{one.points:g}") for one in result.results]
    assert (after[0], after[2]) == (before[0], before[2])
    assert after[1] != before[1]
    (subs / "s003").rename(subs / "shown")
    for wrong in ("shown", "s0002"):
        with pytest.raises(ValueError, match=f"only.*{wrong}|{wrong}.*s002"):
            grade_class(hw3, subs, out, only=wrong)
    with pytest.warns(UserWarning, match="s003"), pytest.warns(UserWarning, match="shown"):
        grade_class(hw3, subs, out, only=["s001", "hidden"])
    assert ran[2:] == [("s001", "hidden")]


def test_other_limits_and_points_need_no_run(hw3, folders, ran):
    subs, out = folders
    changed = replace(hw3, tests=tuple(replace(t, points=10, limits=STRICT) for t in hw3.tests))
    anew = regrade_class(changed, out)
    assert [one.most for one in anew.results] == [20, 20, 20]
    assert all(one.points < 20 for one in anew.results)
    assert repr(grade_class(changed, subs, out)) == repr(anew)
    assert ran == []
    assert result_of(out, "s001") == anew.results[0]


def test_tables_have_the_columns_that_are_asked_for_and_no_names(hw3, folders, ran):
    subs, out = folders
    told = []
    grade_class(
        hw3,
        subs,
        out,
        columns="moodle",
        pseudonyms=True,
        on_result=lambda result, changed: told.append((result.student, changed)),
    )
    assert told == [("s001", ""), ("s002", ""), ("s003", "")]
    tables = [(out / name).read_text() for name in ("class.csv", "class.html")]
    assert "Full name" in tables[0]
    assert not any("s001" in table for table in tables)
    regrade_class(hw3, out, columns="canvas")
    assert "SIS User ID" in (out / "class.csv").read_text()
    assert ran == []
    for name, wrong in {"columns": "moodel", "pseudonyms": "yes", "on_result": "print"}.items():
        with pytest.raises((TypeError, ValueError), match=name):
            grade_class(hw3, subs, out, **{name: wrong})
    with pytest.raises(AssignmentError, match="key"):
        grade_class(replace(hw3, key=None), subs, out, public=True, pseudonyms=True)


def test_one_of_a_class_is_graded_without_a_table(hw3, folders, ran):
    subs, out = folders
    before = (out / "class.csv").read_bytes()
    (subs / "s003/estimate_state.py").write_text("def estimate_state(step):\n    return None\n")
    gradescope = out.parent / "results.json"
    result = grade_submission(hw3, subs / "s003", out, only="shown", gradescope=gradescope)
    assert ran == [("s003", "shown")]
    assert result.to_json() == result_of(out, "s003").to_json()
    assert json.loads(gradescope.read_text())["score"] == result.points
    with warnings.catch_warnings():  # on the results of others
        warnings.simplefilter("error")
        (again,) = grade_class(hw3, subs / "s003", out, only="shown").results
    assert again.to_json() == result.to_json()
    assert (out / "class.csv").read_bytes() == before


def test_results_of_students_without_a_submission_are_told(hw3, folders, ran):
    subs, out = folders
    shutil.rmtree(subs / "s003")
    with pytest.warns(UserWarning, match=r"regrade.*s003"):
        result = grade_class(hw3, subs, out)
    assert [one.student for one in result.results] == ["s001", "s002"]
    assert ran == []


def test_a_submission_is_opened_once(hw3, folders, tmp_path, monkeypatch):
    subs, _ = folders
    opened = []
    true = progress.open_submission
    monkeypatch.setattr(
        progress, "open_submission", lambda path, *more: opened.append(path) or true(path, *more)
    )
    grade_class(hw3, subs, tmp_path / "again")
    assert opened == [str(subs / student) for student in ("s001", "s002", "s003")]


def test_regrading_refuses_what_was_graded_by_other_tests(hw3, folders, tmp_path):
    _, out = folders
    with pytest.raises(FileNotFoundError):
        regrade_class(hw3, tmp_path / "nothing")
    before = (out / "s001/result.json").read_bytes()
    shown, hidden = hw3.tests
    noisier = replace(hidden, task=replace(hidden.task, noise=14.0), limits=STRICT)
    with pytest.raises(ValueError, match=r"hidden.*s001"):
        regrade_class(replace(hw3, tests=(shown, noisier)), out)
    assert (out / "s001/result.json").read_bytes() == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_a_process_that_is_killed_loses_its_test_alone_which_is_done_again(hw3, tmp_path):
    for student in ("s001", "s002", "s003", "s004"):
        solution(tmp_path / "subs" / student)
    with ProcessPoolExecutor(1) as others:
        killing = others.submit(kill_a_worker_of, os.getpid())
        result = grade_class(hw3, tmp_path / "subs", tmp_path / "out", executor=2)
        killing.result()
    assert result.is_full


def kill_a_worker_of(parent):
    """Kill one of the processes of a pool that grades, once it is there."""
    own = {os.getpid(), os.getppid()}

    def worker():
        for task in Path(f"/proc/{parent}/task").iterdir():
            for child in map(int, (task / "children").read_text().split()):
                with suppress(OSError):  # it has ended
                    name = Path(f"/proc/{child}/cmdline").read_bytes()
                    if child not in own and b"spawn_main" in name and has_children(child):
                        return child
        return None

    os.kill(wait_for(worker), signal.SIGKILL)


def has_children(process):
    """Whether a process has started another one: a worker that grades has a zygote."""
    tasks = Path(f"/proc/{process}/task").iterdir()
    return any((task / "children").read_text().strip() for task in tasks)


def test_two_submissions_of_one_student_and_results_among_them_are_refused(hw3, folders, tmp_path):
    subs, _ = folders
    for out in (subs / "out", subs / "s001/out", subs):
        with pytest.raises(ValueError, match=r"\bout\b"):
            grade_class(hw3, subs, out)
    (subs / "s001.py").write_text("def estimate_state(step):\n    return None\n")
    with pytest.raises(AssignmentError, match=r"s001\.py"):
        grade_class(hw3, subs, tmp_path / "other")
