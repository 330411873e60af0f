"""The limits that ship: of all tasks, as these are now, and as sharp as they should be."""

import pytest

from grading_promises import promises
from robsim.tasks import task
from robsim.tasks._marks.calibration import POWER
from robsim.tasks._marks.files import shipped_calibrations, shipped_limits
from robsim.tasks._marks.tolerance import bound_rank
from sizes import thorough

NAMES = sorted(shipped_calibrations())


@pytest.mark.parametrize("name", NAMES)
def test_limits_are_those_of_the_task_and_its_solutions_as_they_are(name):
    calibration = shipped_calibrations()[name]
    assert calibration.stale(task(name)) is None, "run ./run limits"
    assert shipped_limits(task(name)) == calibration.limits
    assert calibration.limits.keys() == {score.name for score in task(name).scores}
    assert shipped_limits(task(name, runs=11)) is None  # other parameters
    # They promise 1 %, and every wrong solution fails.
    assert (calibration.false_fail, calibration.confidence) == (0.01, 0.95)
    assert calibration.rank == bound_rank(calibration.tests, 0.01, 0.95)
    for one in calibration.solutions:
        if one.is_right:
            assert one.failing < calibration.rank, one
            assert one.points == 1
        else:
            assert one.rate >= POWER, one
    naive = next(one for one in calibration.solutions if one.name == "naive")
    assert naive.points < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("name", thorough(NAMES, ["estimate"]))
def test_a_few_tests_on_fresh_runs_come_out_as_promised(name):
    found = promises(shipped_calibrations()[name], graded=4, graded_wrong=2, seed=77)
    assert len(found) == len(task(name).solutions)
    for promise in found:
        assert promise.holds, promise
