"""Limits of an assignment come from its own solutions, once for tests with the same task."""

import pytest

from commands import command
from robsim.teach import AssignmentError, Key, calibrate_assignment, load_assignment, new_assignment
from robsim.teach.assignments import calibration as calibration
from robsim.teach.tasks.marks.calibration import shipped_calibrations

QUICK = {"false_fail": 0.5, "confidence": 0.5, "progress": False}


@pytest.fixture(autouse=True)
def _few(monkeypatch):
    """As few tests as show that it works."""
    monkeypatch.setattr("robsim.teach.tasks.marks.calibrate.PILOT_TESTS", 3)
    for name in ("RIGHT_TESTS", "WRONG_TESTS"):
        monkeypatch.setattr(f"robsim.teach.tasks.marks.calibrate.{name}", 2)
    monkeypatch.setattr("robsim.teach.tasks.marks.calibrate.STAGES", ((2, 0.0),))


@pytest.fixture
def folder(tmp_path):
    made = new_assignment("estimate", tmp_path / "hw1", seed=1).folder
    file = made / "assignment.toml"
    text = file.read_text().replace("steps = 60", "steps = 20").replace("runs = 10", "runs = 2")
    file.write_text(text)
    return made


@pytest.mark.long
def test_limits_are_written_with_what_they_rest_on(folder):
    few = calibrate_assignment(folder, **QUICK, provisional=True)
    made = load_assignment(folder)
    for test in made.tests:
        assert dict(test.limits) == dict(few[test.name].limits)
        assert "few tests" in test.provisional
    assert (folder / ".calibrating").exists()  # for the exact ones
    found = calibrate_assignment(folder, **QUICK)
    assert set(found) == {"public", "hidden"}
    assert found["public"] is found["hidden"]  # the same task
    made = load_assignment(folder)
    for test in made.tests:
        assert dict(test.limits) == dict(found[test.name].limits)
        assert test.stale == test.provisional == ""
    assert not (folder / ".calibrating").exists()
    reference = folder / "solutions/estimate/right/reference/estimate_state.py"
    reference.write_text(reference.read_text() + "\n# another one\n")
    assert load_assignment(folder).tests[0].stale
    run = command("assignment", "check", str(folder), "--jobs", "1")
    assert run.exit_code == 2
    assert "calibrate again" in run.stderr


def test_a_new_assignment_has_the_limits_of_the_shipped_task(tmp_path):
    for test in new_assignment("measure", tmp_path / "hw1", seed=1).tests:
        assert dict(test.limits) == dict(shipped_calibrations()["measure"].limits)
        assert test.stale == ""
        assert "ships with robsim" in test.provisional


@pytest.mark.slow
def test_another_task_has_limits_of_its_own(folder):
    file = folder / "assignment.toml"
    first, second = file.read_text().rsplit("slip = ", 1)
    file.write_text(first + "slip = 0.9 # " + second)
    found = calibrate_assignment(folder, **QUICK)
    assert found["public"].parameters["slip"] != found["hidden"].parameters["slip"] == 0.9
    assert found["public"].seed != found["hidden"].seed


def test_seeds_come_from_the_key(folder, monkeypatch):
    asked = []

    def calibrate(*arguments, seed, **options):
        asked.append(seed)
        raise KeyboardInterrupt

    monkeypatch.setattr(calibration, "calibrate_task", calibrate)
    with pytest.raises(KeyboardInterrupt):
        calibrate_assignment(folder, **QUICK)
    assert asked == [Key.load(folder / "key").world_seed("", "calibration public", 0)]
    (folder / "key").unlink()
    with pytest.raises(AssignmentError, match="key"):
        calibrate_assignment(folder, **QUICK)


@pytest.mark.slow
def test_one_that_is_ended_goes_on(folder, monkeypatch):
    whole = calibration.calibrate_task

    def ended(*arguments, **options):
        whole(*arguments, **options)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(calibration, "calibrate_task", ended)
        with pytest.raises(KeyboardInterrupt):
            calibrate_assignment(folder, **QUICK)
    kept = [file.name for file in (folder / ".calibrating").rglob("*.sqlite")]
    assert sorted(kept) == ["right.sqlite", "wrong.sqlite"]
    calibrate_assignment(folder, **QUICK)
    assert not (folder / ".calibrating").exists()


@pytest.mark.long
def test_the_command_calibrates(folder):
    words = ("assignment", "calibrate", str(folder), "--confidence", "0.5", "--false-fail")
    run = command(*words, "0.5", "--jobs", "1")
    assert run.exit_code == 0, run.stderr
    assert "public, hidden" in run.stdout
    assert all(test.limits for test in load_assignment(folder).tests)
    assert command(*words, "2").exit_code == 2


def test_a_folder_that_is_no_assignment_is_refused(tmp_path):
    for words in (("calibrate",), ("check",), ("pack", "--students", "s.zip")):
        run = command("assignment", *words, str(tmp_path))
        assert run.exit_code == 2
        assert "assignment" in run.stderr
