"""The check of an assignment finds what would be found when marks are out."""

import json
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest

from commands import command
from robsim.teach import check_assignment, load_assignment, new_assignment
from robsim.teach.assignments import checking as check
from robsim.teach.assignments import rehearsal
from robsim.teach.tasks.marks.calibration import shipped_calibrations
from small_assignments import LIMITS, retell

TIGHT = {"position": {"full": 1.0001, "zero": 1.0002}}
WIDE = {"position": {"full": 900.0, "zero": 1000.0}, "heading": {"full": 900.0, "zero": 1000.0}}
WIDE["consistency"] = {"full": 1e6, "zero": 1e7, "low": 1e-6, "low_zero": 1e-7}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An assignment with short runs, and without tests of the teacher's own."""
    folder = tmp_path_factory.mktemp("made") / "hw1"
    new_assignment("estimate", folder, seed=1)
    file = folder / "assignment.toml"
    text = file.read_text().replace("steps = 60", "steps = 20").replace("runs = 10", "runs = 2")
    file.write_text(text.partition("# Tests of your own")[0])
    retell(folder, steps=20, runs=2)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    shutil.copytree(made, tmp_path / "hw1")
    return tmp_path / "hw1"


def write_limits(folder, limits):
    tests = {name: {"limits": {**LIMITS, **limits}} for name in ("public", "hidden")}
    (folder / "limits.json").write_text(json.dumps({"format": 1, "tests": tests}))


@pytest.fixture
def cast(monkeypatch):
    """Let only some be graded, by a part of their names."""

    def only(*names):
        def some(assignment):
            parts = rehearsal.cast_of(assignment)
            return [part for part in parts if any(name in part.name for name in names)]

        monkeypatch.setattr(check, "cast_of", some)

    return only


def problems(folder):
    return {one.kind: one.sentence for one in check_assignment(folder, progress=False).problems}


NOT_CALIBRATED = {"limits of public", "limits of hidden"}


def test_the_class_has_all_that_is_known(made):
    cast = {part.name: part for part in rehearsal.cast_of(load_assignment(made))}
    assert sum(part.expected == rehearsal.LESS for part in cast.values()) >= 5
    assert {f"hostile: {name}" for name in ("exit", "hang", "patch", "truth")} <= set(cast)
    gamed = ("robsim's own", "always nothing", "one step in 60", "the template of robsim new")
    assert {f"gamed: {name}" for name in gamed} <= set(cast)
    notebook = json.loads(cast["right: reference, as a notebook"].files["estimate.ipynb"])
    assert "estimate_state = " in "".join(notebook["cells"][0]["source"])
    for part in cast.values():  # all of them are programs
        for name, content in part.files.items():
            if name.endswith(".py"):
                compile(content, name, "exec")
            assert b"SLOT" not in content
            assert b"NOTHING" not in content


@pytest.mark.parametrize(("coding", "first"), [("utf-8-sig", ""), ("latin-1", "# coding: latin-1")])
def test_the_notebook_of_the_class_has_a_solution_in_its_coding(folder, coding, first):
    (file,) = folder.glob("solutions/estimate/right/reference/estimate_state.py")
    text = f"{first}\nNAME = 'Zo\u00eb'\n{file.read_text(encoding='utf-8')}"
    file.write_bytes(text.encode(coding))
    cast = {part.name: part for part in rehearsal.cast_of(load_assignment(folder))}
    notebook = json.loads(cast["right: reference, as a notebook"].files["estimate.ipynb"])
    source = "".join(notebook["cells"][0]["source"])
    assert "'Zo\u00eb'" in source
    compile(source, "cell", "exec")


@pytest.mark.long
def test_what_is_as_it_should_be_is_well(folder, cast):
    cast("as a notebook", "naive", "empty submission", "exit")
    write_limits(folder, {})
    report = check_assignment(folder, progress=False)
    assert {one.kind for one in report.problems} == NOT_CALIBRATED
    verdicts = {title: row["verdict"] for title, row in report.tables[0].records()}
    assert verdicts.pop("wrong: naive") == "more than half"  # by these wide limits
    assert {title for title, verdict in verdicts.items() if verdict != "passed"} == NOT_CALIBRATED
    cast_of_it = {"right: reference, as a notebook", "empty submission"}
    assert cast_of_it | {"hostile: exit", "key"} <= set(verdicts)


@pytest.mark.slow
def test_what_has_no_work_in_it_gets_nothing(folder, cast):
    cast("gamed: robsim's", "gamed: always", "gamed: one step", "gamed: the template")
    shipped = shipped_calibrations()["estimate"].as_record()["limits"]
    write_limits(folder, shipped)
    report = check_assignment(folder, progress=False)
    assert {one.kind for one in report.problems} == NOT_CALIBRATED


@pytest.mark.slow
def test_hostile_ones_get_nothing_and_end_nothing(folder, cast):
    cast("hostile", "right: unscented")
    write_limits(folder, {})
    report = check_assignment(folder, progress=False)
    assert {one.kind for one in report.problems} == NOT_CALIBRATED
    got = {title: row["got"] for title, row in report.tables[0].records()}
    assert got["hostile: exit"] == got["hostile: hang"] == "0 of 9"


@pytest.mark.slow
@pytest.mark.parametrize(("one", "limits"), [("right: smaller_r", TIGHT), ("wrong: naive", WIDE)])
def test_a_right_one_without_and_a_wrong_one_with_full_points_is_a_problem(
    folder, cast, one, limits
):
    cast(one)
    write_limits(folder, limits)
    assert set(problems(folder)) == NOT_CALIBRATED | {one}


@pytest.mark.parametrize("gradings", [[True], [False, True, True], [False, False, True]])
def test_one_of_three_gradings_is_chance(folder, cast, monkeypatch, gradings):
    cast("right: unscented")
    write_limits(folder, {})
    expected = iter(gradings)

    def graded(plan, parts, place, **options):
        return {part.name: SimpleNamespace(expected=next(expected), tests=()) for part in parts}

    monkeypatch.setattr(check, "graded", graded)
    monkeypatch.setattr(check, "_points", lambda part, result: (8.9, 9))
    monkeypatch.setattr(check, "_is_expected", lambda part, result: result.expected)
    assert ("right: unscented" in problems(folder)) == (gradings.count(False) == 2)
    assert list(expected) == []


def test_what_is_still_is_looked_at_before_anything_is_run(folder, cast):
    cast("nobody")
    write_limits(folder, {})
    shutil.copy(folder / "key", folder / "start/key.txt")
    toml = folder / "assignment.toml"
    toml.write_text(toml.read_text().replace("points = 6", "points = 7"))
    found = problems(folder)
    assert "start/key.txt" in found["for students"]
    assert "7" in found["sheet.md"]
    (folder / "sheet.md").write_text("Do it.")
    assert "estimate_state" in problems(folder)["sheet.md"]


@pytest.mark.long
def test_a_number_of_the_sheet_belongs_to_the_tests(folder, cast):
    cast("nothing")
    write_limits(folder, {})
    assert "sheet.md" not in problems(folder)
    toml, sheet = folder / "assignment.toml", folder / "sheet.md"
    toml.write_text(re.sub("dropout = .*", "dropout = 0.3", toml.read_text(), count=1))
    assert re.search(r"dropout is 0\.\d+, must be 0\.3", problems(folder)["sheet.md"])
    retell(folder, dropout=0.3)
    sheet.write_text(sheet.read_text().replace("| `runs` | `2` |", "Two runs."))
    report = check_assignment(folder, progress=False)
    assert "sheet.md" not in {one.kind for one in report.problems}
    notes = {title: row["verdict"] for title, row in report.tables[0].records()}
    assert notes["sheet.md"] == "no row for `runs`"
    assert notes["numbers of hidden"] == "dropout (0.2, not 0.3)"
    assert replace(report, problems=()).headline == "hw1 passed all checks, with 2 remarks"
    assert report.remarks[0] == "numbers of hidden: others, dropout (0.2, not 0.3)"


@pytest.mark.long
def test_the_command_exits_with_what_was_found(folder, cast):
    run = command("assignment", "check", str(folder))
    assert run.exit_code == 2  # it has no limits
    cast("empty submission")
    write_limits(folder, {})
    run = command("assignment", "check", str(folder), "--json")
    assert run.exit_code == 1, run.stderr
    assert json.loads(run.stdout)["checks"]["empty submission"]["verdict"] == "passed"
