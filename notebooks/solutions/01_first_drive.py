"""The answers of the notebook 01_first_drive, and mistakes that students make."""

import math

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


def some_mask(rng):
    mask = np.zeros((rng.integers(12, 20), rng.integers(21, 30)), dtype=np.uint8)
    top, left = rng.integers(0, 6, 2)
    mask[top : top + rng.integers(2, 6), left : left + rng.integers(8, 14)] = 1
    mask[top, left] = 0
    return (mask,)


@exercise(
    cases=some_mask,
    hint="np.nonzero(mask) gives the rows and the columns of these pixels. Which of both is u?",
    mistakes={
        "u and v are exchanged: the first index of an array is the row, that is v.": (
            lambda mask: np.argwhere(mask).mean(axis=0)
        ),
        "Pixels count from 0: there is nothing to add.": (
            lambda mask: np.argwhere(mask).mean(axis=0)[::-1] + 1
        ),
        "This is the middle of the bounding box: take the mean over all pixels.": (
            lambda mask: (np.argwhere(mask).min(axis=0) + np.argwhere(mask).max(axis=0))[::-1] / 2
        ),
        "This is the centre of the whole array: count only nonzero pixels.": (
            lambda mask: ((mask.shape[1] - 1) / 2, (mask.shape[0] - 1) / 2)
        ),
    },
)
def mean_pixel(mask):
    """Return the mean position (u, v) of the nonzero pixels of a mask of shape (H, W)."""
    rows, columns = np.nonzero(mask)
    return columns.mean(), rows.mean()


def two_markers(rng):
    blue, angle = rng.uniform(100, 500, 2), rng.uniform(-1.4, 1.4) + math.pi * rng.integers(0, 2)
    return blue + 43 * np.array((math.cos(angle), math.sin(angle))), blue


def turned(red, blue, by):
    return robsim.wrap_angle(math.atan2(red[1] - blue[1], red[0] - blue[0]) + by)


@exercise(
    cases=two_markers,
    hint="First compute the direction from blue to red. A quarter of a turn is pi / 2.",
    mistakes={
        "The robot looks the other way: clockwise angles are positive, since v points down.": (
            lambda red, blue: turned(red, blue, math.pi / 2)
        ),
        "This is the direction from blue to red: the heading is perpendicular to it.": (
            lambda red, blue: turned(red, blue, 0)
        ),
        "It leaves the interval from -pi to pi: wrap it with robsim.wrap_angle.": (
            lambda red, blue: math.atan2(red[1] - blue[1], red[0] - blue[0]) - math.pi / 2
        ),
        "It is in degrees, and must be in radians.": (
            lambda red, blue: math.degrees(turned(red, blue, -math.pi / 2))
        ),
        "v points down already: its sign needs no change.": lambda red, blue: robsim.wrap_angle(
            math.atan2(blue[1] - red[1], red[0] - blue[0]) - math.pi / 2
        ),
    },
)
def heading_of(red, blue):
    """Return the heading (rad, from -pi to pi) from the centroids (u, v) of both markers."""
    u, v = red - blue
    return robsim.wrap_angle(math.atan2(v, u) - math.pi / 2)


@exercise(
    cases=lambda rng: (rng.uniform(-3.1, 3.1), rng.uniform(-3.1, 3.1)),
    hint="Which function of robsim brings an angle back to the interval from -pi to pi?",
    mistakes={
        "Wrap the difference: robsim.wrap_angle.": lambda measured, true: measured - true,
        "The sign is wrong: an error is measured minus true.": (
            lambda measured, true: robsim.wrap_angle(true - measured)
        ),
        "An error has a sign.": lambda measured, true: abs(robsim.wrap_angle(measured - true)),
        "Angles from -pi to pi, not from 0 to 2 pi.": lambda measured, true: (
            (measured - true) % (2 * math.pi)
        ),
    },
)
def heading_error(measured, true):
    """Return measured minus true heading (rad), wrapped to the interval from -pi to pi."""
    return robsim.wrap_angle(measured - true)
