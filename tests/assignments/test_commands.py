"""The commands of an assignment, from a new folder to marks."""

import csv
import shlex
import shutil

import pytest

from commands import command
from robsim.cli import assignment as commands
from robsim.cli import grade
from robsim.teach import SubmissionResult, grade_class, load_assignment, regrade_class
from robsim.teach.reports import marks_table
from small_assignments import PATIENT, TESTS, assignment, drawn_quickly, retell, solution
from submissions import packed

# --- the examples of the commands


def run(function, *more, cwd, status=(0,)):
    words = shlex.split(function.__doc__.rpartition("Example: ")[2])
    assert words[0] == "robsim"
    done = command(*words[1:], *more, cwd=cwd)
    assert done.exit_code in status, done.stderr
    return done


#: Processes take longer to start than these few runs.
ALONE = ("--jobs", "1")


@pytest.mark.slow
def test_the_examples_lead_from_a_new_folder_to_marks(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.teach.tasks.marks.calibrate.PILOT_TESTS", 3)
    monkeypatch.setattr("robsim.teach.tasks.marks.calibrate.WRONG_TESTS", 2)
    run(commands.new, "--no-calibrate", "--seed", "1", cwd=tmp_path)
    folder = tmp_path / "hw1"
    file = folder / "assignment.toml"
    text = file.read_text().replace("runs = 10", "runs = 2").replace("steps = 150", "steps = 20")
    file.write_text(text.partition("# Tests of your own")[0])
    retell(folder, steps=20, runs=2)
    for wrong in (folder / "solutions/park/wrong").iterdir():
        if wrong.name != "naive":
            shutil.rmtree(wrong)
    run(
        commands.calibrate,
        "--false-fail",
        "0.5",
        "--confidence",
        "0.5",
        *ALONE,
        cwd=tmp_path,
    )
    # What is hostile, and the doctor, are tried elsewhere.
    rehearsal = "robsim.teach.assignments.rehearsal"
    monkeypatch.setattr(f"{rehearsal}.hostile_submissions", lambda _: ())
    monkeypatch.setattr("robsim.teach.assignments.marking.findings._SECONDS", 0.1)
    # With limits of so few tests, right ones may fail.
    assert "right: reference" in run(commands.check, *ALONE, cwd=tmp_path, status=(0, 1)).stdout
    run(commands.pack, cwd=tmp_path)
    assert (tmp_path / "hw1-students.zip").is_file()
    folder.rename(tmp_path / "hw3")
    solution(tmp_path / "submissions/anna", kind="park")
    (tmp_path / "submissions/ben").mkdir()
    assert "anna" in run(grade.grade, cwd=tmp_path, status=(1,)).stdout
    assert (tmp_path / "graded/class.html").is_file()


def test_what_makes_no_sense_is_refused(tmp_path):
    for named, words in {
        "--students": ("pack", str(tmp_path)),
        "--install": ("pack", str(tmp_path), "--students", "a.zip", "--install", "x"),
        "exists": ("new", "estimate", str(tmp_path), "--no-calibrate"),
        "'measure'": ("new", "mesure", str(tmp_path / "x"), "--no-calibrate"),
    }.items():
        done = command("assignment", *words)
        assert done.exit_code == 2
        assert named in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("--columns", "moodle", "--student", "anna"),
        ("--pseudonyms", "--public"),
        ("--groups", "groups.csv", "--gradescope", "results.json"),
        ("--only", "anna", "--regrade"),
        ("--feedback", "f.zip", "--play", "hidden"),
        ("--run", "3"),
    ],
)
def test_an_option_without_effect_is_refused(tmp_path, words):
    done = command("grade", str(assignment(tmp_path / "hw3")), str(tmp_path), *words)
    assert done.exit_code == 2
    assert words[0] in done.stderr


# --- from zips to marks


def test_zips_become_marks(tmp_path):
    text = PATIENT + TESTS.replace("runs = 2", "runs = 1")
    hw3 = load_assignment(assignment(tmp_path / "hw3", text))
    right = {file.name: file.read_text() for file in solution(tmp_path / "right").iterdir()}
    wrong = "def estimate_state(step):\n    return step.k / 0\n"
    limits = tmp_path / "hw3/limits.json"
    exact = limits.read_text()
    limits.write_text(exact.replace('{"limits":', '{"provisional": "Not yet", "limits":'))
    hw3 = load_assignment(hw3.folder)
    (tmp_path / "subs").mkdir()
    packed(tmp_path / "subs/anna.zip", right)
    packed(tmp_path / "subs/ben.zip", {"hw3/estimate_state.py": wrong})
    out = tmp_path / "graded"
    with drawn_quickly():
        result = grade_class(hw3, tmp_path / "subs", out)
    assert {one.student: one.points for one in result.results} == {"anna": 6, "ben": 0}
    with (out / "class.csv").open(newline="") as file:
        assert {row["student"]: row["points"] for row in csv.DictReader(file)} == {
            "anna": "6",
            "ben": "0",
        }
    assert {file.name for file in out.iterdir()} == {
        *("anna", "ben", "class.csv", "class.html", "by_hand.csv", "similar.json")
    }
    for one in result.results:
        files = {file.name for file in (out / one.student).iterdir()}
        assert {"index.html", "result.txt", "result.json"} <= files
        assert "teacher.html" not in files
        told = SubmissionResult.from_json((out / one.student / "result.json").read_text())
        assert (told.points, told.is_done) == (one.points, True)
        assert "provisional" in (out / one.student / "result.txt").read_text()
    assert "Not yet" in result.remarks
    assert "provisional" in marks_table(result.results, columns="moodle")
    assert "Not yet." in (out / "class.html").read_text()
    limits.write_text(exact)
    regraded = regrade_class(load_assignment(hw3.folder), out)
    assert "Not yet" not in regraded.remarks
    assert "provisional" not in (out / "anna/result.txt").read_text()
    told = command("grade", str(hw3.folder), "--regrade", "--out", str(out)).stdout
    assert "similar programs, at the end of the page class.html: anna, shipped solution" in told
