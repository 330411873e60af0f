"""Calibration of a task from start to end, small; what is refused; its file."""

import dataclasses
import json

import pytest

from robsim.campaigns.runs import CaseRuns
from robsim.teach import EstimateTask, MeasureTask, TaskCalibration, calibrate_task
from robsim.teach.tasks.marks import calibration as files

TASK = EstimateTask(steps=20, runs=2)
CHOSEN = ("reference", "larger_r", "naive", "no_q")
SOLUTIONS = [one for one in TASK.solutions if one.name in CHOSEN]
FAILING = dataclasses.replace(
    SOLUTIONS[1],
    files={
        "estimate_state": b"def estimate_state(step):\n    raise RuntimeError('no such filter')"
    },
)


@pytest.fixture(scope="module")
def keep(tmp_path_factory):
    return tmp_path_factory.mktemp("keep")


@pytest.fixture(scope="module", autouse=True)
def few_tests():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robsim.teach.tasks.marks.calibrate.PILOT_TESTS", 10)
        patch.setattr("robsim.teach.tasks.marks.calibrate.WRONG_TESTS", 12)
        patch.setattr("robsim.teach.tasks.marks.calibrate.RIGHT_TESTS", 8)
        stages = ((2, 0.0), (4, 0.5), (6, 1.0))
        patch.setattr("robsim.teach.tasks.marks.calibrate.STAGES", stages)
        yield


def calibrated(keep, **more):
    return calibrate_task(
        TASK,
        SOLUTIONS,
        false_fail=0.2,
        confidence=0.8,
        tests=20,
        seed=5,
        store=keep / "runs",
        progress=False,
        **more,
    )


@pytest.fixture(scope="module")
def calibration(keep, few_tests):
    return calibrated(keep)


pytestmark = pytest.mark.long


def test_right_solutions_pass_the_tests_that_limits_come_from(calibration):
    marks = {one.name: one for one in calibration.solutions}
    assert tuple(marks) == CHOSEN
    # of 20 values the 2nd largest, as P(B(20, 0.2) >= 2) = 0.93 and >= 3 0.79
    assert calibration.rank == 2
    right = [marks["reference"], marks["larger_r"]]
    assert max(one.failing for one in right) == 1
    assert [one.tests for one in calibration.solutions] == [20, 20, 12, 12]
    assert marks["reference"].statistics["position"] == 1
    assert marks["reference"].points == 1


def test_wrong_solutions_fail_and_get_less(calibration):
    naive, no_q = calibration.solutions[2:]
    assert naive.rate > 0.9
    assert naive.points < 0.5
    limit = calibration.limits["position"]
    assert limit.zero == max(naive.statistics["position"], 1.5 * limit.full)
    assert no_q.rate_interval[0] < no_q.rate <= no_q.rate_interval[1]
    weak = dataclasses.replace(no_q, failing=9)
    passing = dataclasses.replace(calibration, solutions=(*calibration.solutions[:3], weak))
    assert passing.verdict == "some wrong solutions pass"


def test_the_same_call_goes_on_with_the_runs_that_are_kept(calibration, keep, monkeypatch):
    def refuse(*_):
        raise AssertionError("a run was done again")

    monkeypatch.setattr("robsim.campaigns.runs.CaseRuns.row", refuse)
    assert calibrated(keep) == calibration


def test_provisional_limits_come_from_few_tests_which_the_exact_ones_go_on_from(
    calibration, keep, tmp_path, monkeypatch
):
    done, row = [], CaseRuns.row

    def noted(self, run):
        done.append((*self.case.labels.values(), run))
        return row(self, run)

    monkeypatch.setattr(CaseRuns, "row", noted)
    few = calibrated(tmp_path, provisional=True)
    assert len(done) == 2 * (8 + 8 + 6 + 4) == len({*done})  # none twice
    assert (few.provisional, few.rank, few.tests) == ("few tests", 0, 8)
    assert few.why_provisional in few.remarks
    assert calibration.why_provisional == ""
    marks = {one.name: one for one in few.solutions}
    # No test is passed, and points end at the median of naive.
    assert (marks["naive"].tests, marks["no_q"].tests) == (6, 4)
    assert 1 <= few.limits["position"].full < marks["naive"].statistics["position"]
    assert TaskCalibration.from_record(json.loads(json.dumps(few.as_record()))) == few
    with pytest.raises(ValueError, match="provisional"):
        TaskCalibration.from_record(few.as_record() | {"provisional": "guess"})
    assert calibrated(tmp_path) == calibration  # as if these had not been run before


def test_a_file_has_all_of_it(calibration, tmp_path):
    file = tmp_path / "limits.json"
    files.write_calibrations(file, {"one": calibration})
    assert files.read_calibrations(file) == {"one": calibration}
    text = file.read_text().replace('"format": 1', '"format": 2')
    for broken in (text, '{"one": {"format": 1, "limits": {}}}', "["):
        file.write_text(broken)
        with pytest.raises(ValueError, match=r"limits\.json"):
            files.read_calibrations(file)


def test_what_changed_is_to_be_calibrated_again(calibration):
    record = json.loads(json.dumps(calibration.as_record()))
    known = TaskCalibration.from_record(record)
    assert known.stale(TASK, SOLUTIONS) is None
    other_task = EstimateTask(steps=20, runs=2, slip=0.31)
    assert known.stale(other_task, SOLUTIONS).startswith("the task differs")
    changed = dataclasses.replace(SOLUTIONS[1], files=SOLUTIONS[1].files | {"more": b"x = 1"})
    assert known.stale(TASK, [SOLUTIONS[0], changed, *SOLUTIONS[2:]]).startswith("the solutions")
    assert known.stale(TASK).startswith("the solutions")


@pytest.mark.parametrize(
    ("solutions", "named"),
    [
        ([SOLUTIONS[0], *SOLUTIONS[2:]], "another"),
        (SOLUTIONS[1:], "'reference' first"),
        ([one for one in SOLUTIONS if one.name != "naive"], "'naive'"),
        (MeasureTask().solutions, "estimate_state.*measure"),
        ([SOLUTIONS[0], FAILING, *SOLUTIONS[2:]], "'larger_r'.*no such filter"),
    ],
)
def test_solutions_that_are_no_help_are_refused(solutions, named):
    with pytest.raises(ValueError, match=named):
        calibrate_task(TASK, solutions, false_fail=0.5, confidence=0.5, progress=False)


def test_too_few_tests_for_a_promise_are_refused():
    with pytest.raises(ValueError, match=r"tests.*299"):
        calibrate_task(TASK, SOLUTIONS, tests=298)
