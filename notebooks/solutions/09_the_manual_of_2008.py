"""The answers of the notebook 09_the_manual_of_2008, and mistakes that students make."""

import math

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


def heading_and_count(rng):
    """Return a heading away from the middle between two; near pi in every third case."""
    count = int(rng.choice((5, 8, 36)))
    if rng.random() < 0.3 and count % 2 == 0:  # nearest to pi, on either side of it
        return rng.choice((-1, 1)) * (math.pi - rng.uniform(0.1, 0.4) * 2 * math.pi / count), count
    whole = rng.integers(-count // 2 + 1, count // 2)
    return (whole + rng.uniform(0.1, 0.4) * rng.choice((-1, 1))) * 2 * math.pi / count, count


def not_the_nearest(result, heading, count):
    """Return the fault of a heading, or None; pi and -pi are the same."""
    right = drawn_heading.right(heading, count)
    same = abs(robsim.wrap_angle(result - right)) < 1e-6 and abs(result) < math.pi + 1e-6
    return None if same else f"it must be {right:.6g}."


@exercise(
    cases=heading_and_count,
    judge=not_the_nearest,
    hint="How far apart are neighbours? How many such distances is the heading, rounded?",
    mistakes={
        "This rounds down: take the nearest one.": lambda heading, count: (
            math.floor(heading * count / (2 * math.pi)) * 2 * math.pi / count
        ),
        "The headings lie on a whole turn, 2 pi, not on half of one.": lambda heading, count: (
            round(heading * count / math.pi) * math.pi / count
        ),
        "This is the number of the heading: multiply it by their distance.": (
            lambda heading, count: round(heading * count / (2 * math.pi))
        ),
        "It is in degrees, and must be in radians.": lambda heading, count: math.degrees(
            round(heading * count / (2 * math.pi)) * 2 * math.pi / count
        ),
        "This is the error: return the drawn heading.": lambda heading, count: (
            round(heading * count / (2 * math.pi)) * 2 * math.pi / count - heading
        ),
    },
)
def drawn_heading(heading, count):
    """Return the drawn heading (rad, from -pi to pi): the nearest of `count` evenly spaced ones."""
    distance = 2 * np.pi / count
    return robsim.wrap_angle(round(heading / distance) * distance)


def pixels_and_box(rng):
    yuv = rng.integers(0, 10, (6, 8, 3))
    low = rng.integers(1, 4, 3)
    return yuv, low, low + rng.integers(3, 6, 3)


@exercise(
    cases=pixels_and_box,
    hint="Compare whole arrays. Which function of numpy combines all along the last axis?",
    mistakes={
        "The ends belong to the range: <=, not <.": lambda yuv, low, high: (
            (yuv > low) & (yuv < high)
        ).all(axis=2),
        "All three must lie in their ranges, not one of them.": lambda yuv, low, high: (
            (yuv >= low) & (yuv <= high)
        ).any(axis=2),
        "This looks at the upper ends alone.": lambda yuv, low, high: (yuv <= high).all(axis=2),
        "This looks at the lower ends alone.": lambda yuv, low, high: (yuv >= low).all(axis=2),
        "One value for each pixel, of shape (H, W).": lambda yuv, low, high: (
            (yuv >= low) & (yuv <= high)
        ).astype(int),
    },
)
def in_box(yuv, low, high):
    """Return an array (H, W) with 1 where a pixel belongs to a class, else 0."""
    return ((yuv >= low) & (yuv <= high)).all(axis=2).astype(int)
