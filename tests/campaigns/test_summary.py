"""Means with intervals, and paired differences."""

import numpy as np
import pytest
from scipy import stats

from robsim.campaigns.summary import summary_of


def summary(values, level=0.95):
    return summary_of(
        np.asarray(values, float)[..., np.newaxis],
        by=("filter",),
        groups=[f"g{i}" for i in range(len(values))],
        metrics=("error",),
        level=level,
        failed=0,
    )


def test_means_and_intervals_are_those_of_students_t(rng):
    values = rng.normal(3, 2, (2, 12))
    report = summary(values, level=0.9)
    for group in range(2):
        low, high = stats.t.interval(
            0.9, 11, loc=values[group].mean(), scale=stats.sem(values[group])
        )
        assert report.mean[group, 0] - report.half_width[group, 0] == pytest.approx(low)
        assert report.mean[group, 0] + report.half_width[group, 0] == pytest.approx(high)
        assert report.sd[group, 0] == pytest.approx(values[group].std(ddof=1))


def test_differences_are_those_of_pairs(rng):
    common = rng.normal(0, 10, 20)
    values = np.array([common, common + rng.normal(1, 0.5, 20)])
    report = summary(values)
    low, high = stats.ttest_rel(values[1], values[0]).confidence_interval(0.95)
    assert report.difference[1, 0] - report.difference_half_width[1, 0] == pytest.approx(low)
    assert report.difference[1, 0] + report.difference_half_width[1, 0] == pytest.approx(high)
    assert report.more_runs[1, 0] == 0  # decided, though the means' own intervals overlap
    assert report.half_width[0, 0] > report.difference[1, 0]
    assert "decided" in str(report)


def test_so_many_runs_more_decide_and_one_less_does_not(rng):
    difference = rng.normal(0.2, 1.0, 15)
    report = summary([np.zeros(15), difference])
    more = int(report.more_runs[1, 0])
    assert more > 0
    mean, sd = difference.mean(), difference.std(ddof=1)

    def decides(n):
        return abs(mean) > stats.t.ppf(0.975, n - 1) * sd / np.sqrt(n)

    assert decides(15 + more)
    assert not decides(15 + more - 1)


def test_unknown_numbers_do_not_count():
    report = summary([[1, 2, np.nan, 4], [2, np.nan, 3, 6]])
    assert report.n[:, 0].tolist() == [3, 3]
    assert report.n_pairs[:, 0].tolist() == [3, 2]
    assert report.difference[1, 0] == 1.5


def test_too_few_runs_and_no_difference_are_told():
    report = summary([[1.0], [2.0]])
    assert np.isnan(report.half_width).all()
    assert np.isnan(report.more_runs[1, 0])
    assert "-" in str(report)
    same = summary([[1.0, 2, 3], [1.0, 2, 3]])
    assert same.more_runs[1, 0] == np.inf
    assert "no difference" in str(same)
    assert summary([[1.0, 2, 3], [2.0, 3, 4]]).more_runs[1, 0] == 0  # constant, so decided
    nothing = summary(np.full((2, 3), np.nan))
    assert np.isnan(nothing.mean).all()
