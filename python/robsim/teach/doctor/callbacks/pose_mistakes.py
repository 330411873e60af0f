"""The wrong formulas of a pose that a measurement's results reveal."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from robsim._core import MarkerLayout, wrap_angle
from robsim.base.checks import Floats
from robsim.trace.trace import Bools
from robsim.trace.tracking import FALSE_POSE_LIMITS

_FALSE_DISTANCE, _FALSE_ANGLE = FALSE_POSE_LIMITS
_FITS = 0.9  # of the poses
_CLOSE = (6.0, math.radians(12))  # px, rad
_ROUGHLY = math.radians(60)


def errors(measured: Floats, true: Floats) -> tuple[Floats, Floats]:
    """Return distance (px) and angle (rad) between poses (N, 3)."""
    distance = np.hypot(measured[:, 0] - true[:, 0], measured[:, 1] - true[:, 1])
    return distance, abs(wrap_angle(measured[:, 2] - true[:, 2]))


def are_right(measured: Floats, true: Floats) -> Bools:
    """Return which of the poses (N, 3) are not false."""
    distance, angle = errors(measured, true)
    is_right: Bools = (distance <= _FALSE_DISTANCE) & (angle <= _FALSE_ANGLE)
    return is_right


def mistakes(
    measured: Floats, true: Floats, markers: MarkerLayout, area: tuple[int, int]
) -> Iterator[tuple[str, str]]:
    """Yield kind and sentence of the mistakes that explain wrong poses (N, 3)."""
    distance, angle = errors(measured, true)
    if np.mean(distance > _FALSE_DISTANCE) > 1 - _FITS:
        for kind, sentence, wrong in _positions(true, markers, area):
            if np.mean(np.hypot(*(measured[:, :2] - wrong).T) < _CLOSE[0]) >= _FITS:
                yield kind, sentence
                break
    if np.mean(angle > _FALSE_ANGLE) > 1 - _FITS:
        yield from _heading_mistake(measured[:, 2], true[:, 2])


def _positions(
    true: Floats, markers: MarkerLayout, area: tuple[int, int]
) -> Iterator[tuple[str, str, Floats]]:
    """Yield kind, sentence and positions (N, 2) of mistakes, for true poses."""
    x, y, _ = true.T
    width, height = area
    offset = markers.offset
    place = f"{abs(offset):.0f} px {'behind' if offset > 0 else 'ahead of'} the robot's centre"
    yield (
        "position of midpoint",
        f"its position is the midpoint of the markers, {place}: add step.markers.offset times the "
        "unit vector of the heading",
        _beside(true, -offset),
    )
    for role in markers.roles:
        yield (
            "position of a marker",
            f"its position is the {role} marker ({markers.colors[role]}), not the robot's centre",
            _beside(true, *markers.positions[role]),
        )
    yield (
        "offset reversed",
        "its position is off by twice step.markers.offset: the offset points from the midpoint of "
        "the markers forward, along the heading",
        _beside(true, -2 * offset),
    )
    yield (
        "x and y exchanged",
        "its x and y are exchanged: an image has rows first, image[y, x], but a pose is "
        "(x, y, heading)",
        np.column_stack((y, x)),
    )
    yield (
        "y axis",
        "its y is measured from the bottom: y points down, from the top of the image",
        np.column_stack((x, height - 1 - y)),
    )
    yield (
        "x axis",
        "its x is measured from the right: x points to the right, from the left of the image",
        np.column_stack((width - 1 - x, y)),
    )


def _beside(true: Floats, ahead: float, right: float = 0.0) -> Floats:
    """Return the points at these distances (px) ahead and to the right of the robot."""
    c, s = np.cos(true[:, 2]), np.sin(true[:, 2])
    return np.column_stack((true[:, 0] + ahead * c - right * s, true[:, 1] + ahead * s + right * c))


_ARCTAN2 = "arctan2(dy, dx)"
# Wrong formulas, sign * heading + offset (degrees), with kind and sentence.
_HEADINGS = (
    (1, 180, "heading reversed",
     "its heading is off by 180 degrees: the two markers are exchanged, or the vector between them "
     "is reversed"),
    (1, 90, "heading turned",
      "its heading is off by 90 degrees to the right: take the robot's forward direction, "
      "at right angles to the line between its markers"),
    (1, -90, "heading turned",
      "its heading is off by 90 degrees to the left: take the robot's forward direction, "
      "at right angles to the line between its markers"),
    (-1, 0, "heading anticlockwise",
     "its heading has the wrong sign: y points down, and headings are clockwise on the image"),
    (-1, 90, "swapped arguments",
     f"its heading is 90 degrees minus the right one: arctan2 takes y first, {_ARCTAN2}"),
    (-1, 180, "heading mirrored",
     f"its heading is 180 degrees minus the right one: a sign of dx is wrong in {_ARCTAN2}"),
    (-1, -90, "heading mirrored",
     "its heading is -90 degrees minus the right one: check the order and the signs in "
     f"{_ARCTAN2}"),
)  # fmt: skip
_IN_DEGREES = (
    "heading in degrees",
    "its heading is in degrees: return rad, as from arctan2; see numpy.radians",
)


def _heading_mistake(measured: Floats, true: Floats) -> Iterator[tuple[str, str]]:
    for sign, offset, kind, sentence in _HEADINGS:
        wrong = sign * true + math.radians(offset)
        if np.mean(abs(wrap_angle(measured - wrong)) < _CLOSE[1]) >= _FITS:
            yield kind, sentence
            return
    # A small error of the heading is 57 times as large then.
    if np.mean(abs(wrap_angle(measured - np.degrees(true))) < _ROUGHLY) >= _FITS:
        yield _IN_DEGREES
    elif np.ptp(measured) < _CLOSE[1]:
        yield "heading constant", f"its heading is always {np.degrees(measured[0]):.0f} degrees"
    else:
        yield from _half_turns(measured - true)


def _half_turns(difference: Floats) -> Iterator[tuple[str, str]]:
    """Yield a mistake if some headings are off by 180 degrees and all others are right."""
    # Twice the angle: half a turn becomes none.
    if np.mean(abs(wrap_angle(2 * difference)) < 2 * _CLOSE[1]) >= _FITS:
        share = np.mean(abs(wrap_angle(difference)) > _FALSE_ANGLE)
        yield (
            "heading reversed at times",
            f"its heading is off by 180 degrees in {share:.0%} of the poses: arctan(dy / dx) "
            f"loses half of the directions, {_ARCTAN2} does not; or the markers are exchanged "
            "at times",
        )
