"""The limits that ship: of all tasks, as these are now, and as sharp as they should be."""

import pytest

from grading_promises import calibration, files, promises, tolerance
from robsim.teach import task
from sizes import thorough

NAMES = sorted(files.shipped_calibrations())


@pytest.mark.parametrize("name", NAMES)
def test_limits_are_those_of_the_task_and_its_solutions_as_they_are(name):
    shipped = files.shipped_calibrations()[name]
    assert shipped.stale(task(name)) is None, "run ./run study limits"
    assert shipped.limits.keys() == {score.name for score in task(name).scores}
    assert shipped.stale(task(name, runs=11)) is not None
    # They promise 1 %, and every wrong solution fails.
    assert (shipped.false_fail, shipped.confidence) == (0.01, 0.95)
    assert shipped.rank == tolerance.bound_rank(shipped.tests, 0.01, 0.95)
    for one in shipped.solutions:
        if one.is_right:
            assert one.failing < shipped.rank, one
            assert one.points == 1
        else:
            assert one.rate >= calibration.POWER, one
            assert one.points < 0.2 or one.name != "naive"


@pytest.mark.slow
@pytest.mark.parametrize("name", thorough(NAMES, ["estimate"]))
def test_a_few_tests_on_fresh_runs_come_out_as_promised(name):
    found = promises(files.shipped_calibrations()[name], graded=4, graded_wrong=2, seed=77)
    assert len(found) == len(task(name).solutions)
    for promise in found:
        assert promise.holds, promise
