"""The answers of the notebook 01_first_drive, and mistakes that students make."""

import math

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


def two_markers(rng):
    blue, angle = rng.uniform(100, 500, 2), rng.uniform(-1.4, 1.4) + math.pi * rng.integers(0, 2)
    return blue + 43 * np.array((math.cos(angle), math.sin(angle))), blue


def turned(red, blue, by):
    return robsim.wrap_angle(math.atan2(red[1] - blue[1], red[0] - blue[0]) + by)


@exercise(
    cases=two_markers,
    hint="First compute the direction from blue to red. A quarter of a turn is pi / 2.",
    mistakes={
        "Half a turn off: is your direction from blue to red? Which way is the quarter turn?": (
            lambda red, blue: turned(red, blue, math.pi / 2)
        ),
        "This is the direction from blue to red: the heading is perpendicular to it.": (
            lambda red, blue: turned(red, blue, 0)
        ),
        "It leaves the interval from -pi to pi: wrap it with robsim.wrap_angle.": (
            lambda red, blue: math.atan2(red[1] - blue[1], red[0] - blue[0]) - math.pi / 2
        ),
        "Angles from -pi to pi, not from 0 to 2 pi.": (
            lambda red, blue: turned(red, blue, -math.pi / 2) % (2 * math.pi)
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
    hint="Take 3 and -3 rad: how far apart are these headings, and what does your function return?",
    mistakes={
        "Wrap the difference, in radians, after you subtract: robsim.wrap_angle.": (
            lambda measured, true: measured - true
        ),
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
