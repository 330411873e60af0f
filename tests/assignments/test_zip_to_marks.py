"""From zips to marks: what is handed in is graded, and the files of a class are there."""

import csv

from robsim.teach import SubmissionResult, grade_class, load_assignment
from small_assignments import PATIENT, TESTS, assignment, drawn_quickly, solution
from submissions import packed


def test_zips_become_marks(tmp_path):
    text = PATIENT + TESTS.replace("runs = 2", "runs = 1")
    hw3 = load_assignment(assignment(tmp_path / "hw3", text))
    right = {file.name: file.read_text() for file in solution(tmp_path / "right").iterdir()}
    wrong = "def estimate_state(step):\n    return step.k / 0\n"
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
    assert {file.name for file in out.iterdir()} == {*("anna", "ben", "class.csv", "class.html")}
    for one in result.results:
        files = {file.name for file in (out / one.student).iterdir()}
        assert {"index.html", "teacher.html", "result.txt", "result.json"} <= files
        told = SubmissionResult.from_json((out / one.student / "result.json").read_text())
        assert (told.points, told.is_done) == (one.points, True)
