"""The answers of the notebook 06_grade_a_class, and mistakes that teachers make."""

import math

from robsim.teach.exercises.exercise import exercise


def ratio_and_limits(rng):
    full = rng.uniform(1.05, 1.5)
    zero = full * rng.uniform(1.5, 2)
    return full * (rng.uniform(0.6, 0.9), rng.uniform(1.1, 1.4), 2.5)[rng.integers(3)], full, zero


def clipped(share):
    return min(1.0, max(0.0, share))


@exercise(
    cases=ratio_and_limits,
    hint="How many logarithms lie between the limits, and how many between the ratio and `zero`?",
    mistakes={
        "This is linear in the ratio itself: take logarithms.": (
            lambda ratio, full, zero: clipped((zero - ratio) / (zero - full))
        ),
        "A share is at most 1 and at least 0: also outside of the limits.": (
            lambda ratio, full, zero: math.log(zero / ratio) / math.log(zero / full)
        ),
        "The points grow with the ratio: a larger error must give fewer.": (
            lambda ratio, full, zero: clipped(math.log(ratio / full) / math.log(zero / full))
        ),
        "Between the limits there is a part of the points, too.": (
            lambda ratio, full, zero: float(ratio <= full)
        ),
        "All points are there up to `full`, not up to 1.": lambda ratio, full, zero: clipped(
            math.log(zero / ratio) / math.log(zero)
        ),
    },
)
def share_of_points(ratio, full, zero):
    """Return the share of the points, 0 to 1: all up to a ratio `full`, none from `zero` on."""
    import math

    return min(1, max(0, math.log(zero / ratio) / math.log(zero / full)))


def late(rng):
    return rng.uniform(2, 9), rng.integers(0, 14), rng.uniform(0.08, 0.15), rng.integers(0, 3)


@exercise(
    cases=late,
    hint="How many days cost something? Which share is left after them? Can it be negative?",
    mistakes={
        "Free days take nothing: subtract them from the days.": (
            lambda points, days, per_day, free_days: points * max(0, 1 - per_day * days)
        ),
        "A student within the free days gains nothing: count at least 0 days.": (
            lambda points, days, per_day, free_days: (
                points * max(0, 1 - per_day * (days - free_days))
            )
        ),
        "The points never fall below 0.": lambda points, days, per_day, free_days: (
            points * (1 - per_day * max(0, days - free_days))
        ),
        "A day takes a share of the points, not so many points.": (
            lambda points, days, per_day, free_days: max(
                0, points - per_day * max(0, days - free_days)
            )
        ),
        "Each day takes the same share of all points, not of the rest.": (
            lambda points, days, per_day, free_days: (
                points * (1 - per_day) ** max(0, days - free_days)
            )
        ),
    },
)
def after_late_days(points, days, per_day, free_days):
    """Return the rest of the points after late days, at least 0."""
    return points * max(0, 1 - per_day * max(0, days - free_days))
