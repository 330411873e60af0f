"""Tolerance bounds: how many values they take, and that they keep what they promise."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from robsim.teach.tasks.marks.limits import bound_rank, fewest_values, share_interval


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
