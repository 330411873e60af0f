"""The answers of the notebook 07_is_it_better, and mistakes that students make."""

import numpy as np

from robsim.teach.exercises.exercise import exercise


def pairs(rng):
    hard = rng.uniform(1, 2, 12)  # how hard each run is, for both
    return hard + rng.normal(0, 0.1, 12), hard + rng.normal(0.1, 0.1, 12)


@exercise(
    cases=pairs,
    hint="First the differences of the pairs, then their mean, then their standard deviation.",
    mistakes={
        "The sign is wrong: the difference is second minus first.": (
            lambda first, second: (
                (first - second).mean(),
                2 * (second - first).std(ddof=1) / np.sqrt(len(first)),
            )
        ),
        "numpy divides by N: std(ddof=1) divides by N - 1.": lambda first, second: (
            (second - first).mean(),
            2 * (second - first).std() / np.sqrt(len(first)),
        ),
        "This is the spread of the pairs: their mean has a smaller one, by the root of N.": (
            lambda first, second: ((second - first).mean(), 2 * (second - first).std(ddof=1))
        ),
        "This forgets the pairs: take the spread of the differences.": lambda first, second: (
            (second - first).mean(),
            2 * np.sqrt((first.var(ddof=1) + second.var(ddof=1)) / len(first)),
        ),
        "This is one standard error: the half width is twice as large.": lambda first, second: (
            (second - first).mean(),
            (second - first).std(ddof=1) / np.sqrt(len(first)),
        ),
    },
)
def paired_mean(first, second):
    """Return mean and half width of the interval of second - first, from pairs of runs."""
    pairs = second - first
    return pairs.mean(), 2 * pairs.std(ddof=1) / np.sqrt(len(pairs))


@exercise(
    cases=lambda rng: (rng.integers(10, 60), rng.uniform(1, 2), rng.uniform(0.2, 0.9)),
    hint="The width shrinks with the root of the number of runs. Which runs make it half as wide?",
    mistakes={
        "Half the width takes four times as many runs, not twice as many.": (
            lambda runs, half_width, wanted: runs * half_width / wanted
        ),
        "A narrower interval takes more runs, not fewer.": (
            lambda runs, half_width, wanted: runs * (wanted / half_width) ** 2
        ),
        "The width has a square, not a root.": (
            lambda runs, half_width, wanted: runs * np.sqrt(half_width / wanted)
        ),
        "This is how many runs more: return all of them.": (
            lambda runs, half_width, wanted: runs * (half_width / wanted) ** 2 - runs
        ),
        "The runs so far are missing in it.": (
            lambda runs, half_width, wanted: (half_width / wanted) ** 2
        ),
    },
)
def runs_needed(runs, half_width, wanted):
    """Return how many runs make an interval of half width `wanted`, if `runs` made `half_width`."""
    return runs * (half_width / wanted) ** 2
