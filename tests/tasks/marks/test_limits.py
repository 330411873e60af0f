"""Limits of tasks: tolerance bounds, promises, shipped limits."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

import robsim
from grading_promises import calibration, files, promises, tolerance
from robsim.teach import EstimateTask, MeasureTask, ScoreLimit, task, try_solution
from robsim.teach.tasks.marks import sets
from robsim.teach.tasks.marks.limits import (
    bound_rank,
    fewest_values,
    limits_from,
    share_interval,
)
from sizes import thorough

# --- tolerance bounds


def test_the_fewest_values_are_those_of_the_tables():
    for exceeded, fewest in {0.05: 59, 0.01: 299, 0.005: 598, 0.001: 2995}.items():
        assert fewest_values(exceeded, 0.95) == fewest
        assert bound_rank(fewest, exceeded, 0.95) == 1
        with pytest.raises(ValueError, match=f"{fewest}.*{fewest - 1}"):
            bound_rank(fewest - 1, exceeded, 0.95)


def test_the_rank_is_the_largest_that_has_the_confidence():
    for n in (299, 472, 473, 628, 629, 5000):
        rank = bound_rank(n, 0.01, 0.95)
        assert binom.sf(rank - 1, n, 0.01) >= 0.95 > binom.sf(rank, n, 0.01)


@pytest.mark.parametrize("n", [299, 700])
def test_a_bound_is_exceeded_too_often_as_rarely_as_promised(n, rng):
    # of 2000 bounds; whatever the distribution is, the ranks are those of uniform numbers
    values = np.sort(rng.uniform(size=(2000, n)), axis=1)
    exceeded = 1 - values[:, -bound_rank(n, 0.01, 0.95)]
    too_often = int(np.count_nonzero(exceeded > 0.01))
    assert binomtest(too_often, 2000, 0.05, alternative="greater").pvalue > 1e-4
    # and not for being far too large
    assert too_often > 20


def test_the_interval_of_a_share_is_the_exact_one():
    for count, n in ((0, 60), (1, 60), (57, 60), (60, 60), (9, 1000)):
        expected = binomtest(count, n).proportion_ci(0.95, method="exact")
        assert share_interval(count, n) == pytest.approx((expected.low, expected.high))


# --- limits


PILOT = 60


def as_sets(statistics):
    return sets.Sets(statistics, np.ones(len(statistics)))


def skewed(rng, n, *, scale, shift):
    """Statistics of n tests: skewed, of unequal size, and depending on each other."""
    common = rng.exponential(size=(n, 1))
    own = rng.exponential(size=(n, 3))
    size = np.array([0.02, 0.2, 0.1])
    return np.exp(scale * size * (common + own - 2) + shift)


@pytest.mark.long
def test_right_solutions_fail_as_rarely_as_promised_whatever_the_distribution(rng):
    task, promised, n = EstimateTask(), 0.05, 59
    kinds = [{"scale": 1.0, "shift": 0.0}, {"scale": 1.3, "shift": -0.05}]
    naive = as_sets(np.full((3, 3), 5.0))
    fresh = [skewed(rng, 4000, **kind) for kind in kinds]
    too_often = np.zeros((300, 2), dtype=bool)
    rates = []
    for trial in range(300):
        right = [as_sets(skewed(rng, PILOT + n, **kind)) for kind in kinds]
        limits = limits_from(task, right, [naive], PILOT, 1)
        full = [limits[score.name].full for score in task.scores]
        low = limits["consistency"].low
        fails = [((one > full).any(axis=1) | (one[:, 2] < low)).mean() for one in fresh]
        too_often[trial] = np.array(fails) > promised
        rates.append(fails)
    for count in too_often.sum(axis=0).tolist():
        assert binomtest(count, 300, 0.05, alternative="greater").pvalue > 1e-4
    # the one that is off more often decides; it fails at times
    assert np.mean(rates, axis=0).max() > promised / 10


def test_of_right_solutions_the_worst_test_of_all_sets_the_limits():
    task = MeasureTask()
    rows = np.full((PILOT + 5, 3), 1.0)
    rows[:PILOT, 0] = np.exp(0.04 * np.tile([1, -1], PILOT // 2))
    rows[:PILOT, 1] = np.exp(0.1 * np.tile([1, -1], PILOT // 2))
    rows[-1] = np.exp([0.24, 0.0, 0.0])  # two units of 3 x 0.04
    limits = limits_from(task, [as_sets(rows)], [as_sets(np.full((3, 3), 9.0))], PILOT, 1)
    assert limits["position"].full == pytest.approx(np.exp(0.24))
    assert limits["heading"].full == pytest.approx(np.exp(0.6))  # as many units of its own
    assert limits["lost"].full == pytest.approx(1.1**2)  # a unit is that much at least
    assert as_sets(rows[PILOT:]).points(task.scores, limits).tolist() == pytest.approx([1] * 5)
    second = limits_from(task, [as_sets(rows)], [as_sets(np.full((3, 3), 9.0))], PILOT, 2)
    assert second["position"].full == pytest.approx(1.01)


def test_a_score_that_hardly_ever_differs_does_not_scale_the_limits_of_others():
    rows = np.full((PILOT + 5, 3), 1.0)
    rows[:PILOT, 1] = np.exp(0.1 * np.tile([1, -1], PILOT // 2))
    rows[-1] = [1.09, 1.0, 1.0]  # the only test in which it does
    limits = limits_from(MeasureTask(), [as_sets(rows)], [as_sets(np.full((3, 3), 9.0))], PILOT, 1)
    assert limits["heading"].full < np.exp(0.3)


def test_no_points_are_given_from_the_smallest_wrong_one_and_never_close_to_the_limit():
    task = EstimateTask()
    rows = np.tile(np.exp([[0.1, 0.1, 0.1], [0.1, 0.1, -0.1]]), (PILOT, 1))
    wrong = [as_sets(np.tile(one, (3, 1))) for one in ([3.0, 1.0, 0.01], [2.0, 1.2, 5.0])]
    limits = limits_from(task, [as_sets(rows)], wrong, PILOT, 1)
    assert limits["position"].zero == 2.0
    assert limits["heading"].zero == 1.5 * limits["heading"].full
    assert limits["consistency"].zero == 5.0
    assert limits["consistency"].low_zero == pytest.approx(0.01)


def test_half_as_many_right_frames_as_the_reference_has_give_no_points():
    rows = np.full((PILOT + 5, 3), 1.0)
    wrong = [as_sets(np.full((3, 3), 9.0))]
    limits = limits_from(MeasureTask(), [as_sets(rows)], wrong, PILOT, 1)
    assert limits["lost"].zero == 2.0


LIMITS = {
    "position": ScoreLimit(full=1.5, zero=6.0),
    "heading": ScoreLimit(full=2.0, zero=3.0),
    "consistency": ScoreLimit(full=2.0, zero=4.0, low=0.5, low_zero=0.25),
}


def test_points_are_shares_of_fractions_less_what_failed():
    scores = EstimateTask().scores
    assert sets.points_of(scores, LIMITS, [1.5, 2.0, 0.5], 1.0) == pytest.approx(1)
    assert sets.points_of(scores, LIMITS, [3.0, 2.0, 1.0], 1.0) == pytest.approx(0.35 / 2 + 0.65)
    assert sets.points_of(scores, LIMITS, [1.0, 1.0, 1.0], 0.7) == pytest.approx(0.7)
    assert sets.points_of(scores, LIMITS, [np.nan] * 3, 0.0) == 0


def test_the_statistic_of_a_test_is_that_of_runs_that_came_through():
    task = EstimateTask(runs=2)
    failed = np.array([False, False, False, True, True, True])
    own = sets.Runs(np.array([[2.0, 2, 3]] * 2 + [[8.0, 8, 2]] + [[np.nan] * 3] * 3), failed)
    reference = sets.Runs(np.ones((6, 3)), np.zeros(6, dtype=bool))
    found = sets.sets_of(task, own, reference)
    assert found.through.tolist() == [1, 0.5, 0]
    assert found.statistics[:2] == pytest.approx(np.array([[2, 2, 3], [8, 8, 2]]))
    assert np.isnan(found.statistics[2]).all()


def test_drawn_tests_follow_the_own_ones_and_have_their_distribution(rng):
    task = MeasureTask(runs=4)
    values = np.exp(rng.normal(size=(2400, 3)) * [0.1, 0.2, 0.05] + [0.0, 0.0, 1.0])
    own, reference = (sets.Runs(numbers, np.zeros(2400, bool)) for numbers in (values, values + 1))
    tests = sets.with_drawn(task, own, reference, 5000, seed=3)
    known = sets.sets_of(task, own, reference).statistics
    assert (tests.statistics[:600] == known).all()
    assert tests.through.tolist() == [1] * 5600
    drawn, again = (
        sets.with_drawn(task, own, reference, 5000, seed=seed).statistics[600:] for seed in (3, 4)
    )
    assert (tests.statistics[600:] == drawn).all()
    assert (drawn != again).any()
    for share in (0.1, 0.5, 0.9):
        expected = np.log(np.quantile(known, share, axis=0))
        np.testing.assert_allclose(
            np.log(np.quantile(drawn, share, axis=0)), expected, atol=0.2 * np.log(known).std()
        )


def test_solutions_that_are_known_to_be_wrong_give_no_warning(recwarn):
    task = MeasureTask(runs=1)
    degrees = [one for one in task.solutions if one.name == "degrees"]
    sets.runs_of(task, degrees, 1, seed=1)
    assert not recwarn.list


# --- shipped limits


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


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:.*looks like degrees")
@pytest.mark.parametrize(
    ("answers", "turn", "most"),
    [(lambda k: k == 30, 1.0, 0.05), (lambda k: k % 3, 1.0, 0.65), (lambda k: True, 57.3, 0.2)],
    ids=["one frame in 60", "two frames in three", "degrees"],
)
def test_who_answers_rarely_or_in_degrees_has_few_points(answers, turn, most):
    def measure(step):
        found = robsim.locate(step.blobs, step.markers, image=step.frame, colors=step.colors)
        if found is None or not answers(step.k):
            return None
        return robsim.Measurement(found.pose * (1, 1, turn))

    trial = try_solution(MeasureTask(runs=3), measure=measure, progress=False)
    assert trial.points <= most
    assert not trial.failed
