"""A class is graded: whatever its submissions do, and wherever it is ended."""

import json
import os
import re
import shutil
import signal
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest

from clusters import local_cluster
from robsim.teach import (
    AssignmentError,
    ScoreLimit,
    SubmissionResult,
    grade_class,
    grade_submission,
    load_assignment,
    regrade_class,
)
from robsim.teach.assignments.classes import progress
from small_assignments import LIMITS, TESTS, assignment, drawn_quickly, solution
from submissions import notebook
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
    (earlier / "broken.zip").write_bytes(b"no zip")
    try:
        grade_class(hw3, subs, out)
        text = (out / "class.html").read_text()
        grade_class(hw3, subs, out, pseudonyms=True)
    finally:
        shutil.rmtree(earlier)
    assert "s003, earlier: 2025/anna, earlier: ben" in text
    assert "s001, shipped solution estimate/reference" in text
    assert "anna" not in (out / "class.html").read_text()


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
    (out / "s002/result.json").write_text("{")  # cannot be read, so it is made anew
    result = grade_class(hw3, subs, out)
    assert ran == [(s, test) for s in ("s002", "s003", "s004") for test in ("shown", "hidden")]
    assert [one.is_done for one in result.results] == [True] * 4
    json.loads((out / "s002/result.json").read_text())
    shown, hidden = hw3.tests
    noisier = replace(hidden, task=replace(hidden.task, noise=14.0))
    del ran[:]
    grade_class(replace(hw3, tests=(shown, noisier)), subs, out)
    assert ran == [(student, "hidden") for student in ("s001", "s002", "s003", "s004")]


def test_all_impossible_names_are_told_before_anything_is_graded(hw3, folders, ran, tmp_path):
    subs, _ = folders
    for name in ("a\tb.zip", "c\nd.py", "s001.py", "s002.zip"):
        (subs / name).touch()
    with pytest.raises(AssignmentError) as caught:
        grade_class(hw3, subs, tmp_path / "new")
    for told in (r"'a\\tb'", r"'c\\nd'", "s001, s001.py", "s002, s002.zip"):
        assert told in str(caught.value)
    assert ran == []
    assert not (tmp_path / "new").exists()


def test_files_that_are_no_submissions_and_names_of_our_files_stop_no_class(hw3, folders, tmp_path):
    subs, _ = folders
    (subs / "s001").rename(subs / "class.csv")
    shutil.rmtree(subs / "s003")
    for name in ("Thumbs.db", "grades.xlsx", "readme.txt"):
        (subs / name).touch()
    with pytest.warns(UserWarning, match=r"Thumbs\.db, grades\.xlsx, readme\.txt"):
        result = grade_class(hw3, subs, tmp_path / "new")
    assert [one.student for one in result.results] == ["class.csv", "s002"]
    assert "class.csv" in (tmp_path / "new/class.csv").read_text()
    link = re.search('href="([^"]*class.csv/[^"]*)"', (tmp_path / "new/class.html").read_text())[1]
    assert (tmp_path / "new" / link).is_file()
    assert repr(regrade_class(hw3, tmp_path / "new")) == repr(result)


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
    assert result == result_of(out, "s003")
    assert json.loads(gradescope.read_text())["score"] == result.points
    (again,) = grade_class(hw3, subs / "s003", out, only="shown").results
    assert again == result
    assert (out / "class.csv").read_bytes() == before


def test_a_submission_is_opened_once(hw3, folders, tmp_path, monkeypatch):
    subs, _ = folders
    opened = []
    true = progress.open_submission
    monkeypatch.setattr(
        progress, "open_submission", lambda path, rules: opened.append(path) or true(path, rules)
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
