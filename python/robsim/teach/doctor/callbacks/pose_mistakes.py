"""What a wrong formula makes of a pose: the mistakes that a measurement shows by its results."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from robsim._core import MarkerLayout, wrap_angle
from robsim.base.checks import Floats
from robsim.trace.trace import Bools
from robsim.trace.tracking import FALSE_POSE_LIMITS

_FALSE_DISTANCE, _FALSE_ANGLE = FALSE_POSE_LIMITS
_FITS = 0.9  # of the poses
_CLOSE = (6.0, math.radians(12))  # px, rad
_ROUGHLY = math.radians(60)

Formula = Callable[[Floats], Floats]


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
    """Yield kind and sentence of the mistakes that explain wrong poses.

    Parameters
    ----------
    measured, true : array (N, 3)
        The poses.
    markers : MarkerLayout
        The markers of the robot.
    area : tuple of int
        Width and height of the work area (px).
    """
    distance, angle = errors(measured, true)
    if np.mean(distance > _FALSE_DISTANCE) > 1 - _FITS:
        yield from _first_that_fits(
            _positions(markers, area), lambda formula: _is_close(measured, formula(true))
        )
    if np.mean(angle > _FALSE_ANGLE) > 1 - _FITS:
        yield from _heading_mistake(measured[:, 2], true[:, 2])


def _first_that_fits(
    candidates: list[tuple[str, str, Formula]], fits: Callable[[Formula], bool]
) -> Iterator[tuple[str, str]]:
    for kind, sentence, formula in candidates:
        if fits(formula):
            yield kind, sentence
            return


def _is_close(measured: Floats, wrong: Floats) -> bool:
    distance = np.hypot(measured[:, 0] - wrong[:, 0], measured[:, 1] - wrong[:, 1])
    return bool(np.mean(distance < _CLOSE[0]) >= _FITS)


def _positions(markers: MarkerLayout, area: tuple[int, int]) -> list[tuple[str, str, Formula]]:
    width, height = area
    offset = markers.offset
    return [
        (
            "position of midpoint",
            f"its position is the midpoint of the markers, {abs(offset):.0f} px "
            f"{'behind' if offset > 0 else 'ahead of'} the robot's centre: add step.markers.offset "
            "times the unit vector of the heading",
            lambda true: _beside(true, -offset, 0.0),
        ),
        *(_position_of_marker(markers, role) for role in markers.roles),
        (
            "offset reversed",
            "its position is off by twice step.markers.offset: that points from the midpoint of "
            "the markers forward, along the heading",
            lambda true: _beside(true, -2 * offset, 0.0),
        ),
        (
            "x and y exchanged",
            "its x and y are exchanged: an image has rows first, image[y, x], but a pose is "
            "(x, y, heading)",
            lambda true: true[:, (1, 0)],
        ),
        (
            "y axis",
            "its y is measured from the bottom: y points down, from the top of the image",
            lambda true: np.column_stack((true[:, 0], height - 1 - true[:, 1])),
        ),
        (
            "x axis",
            "its x is measured from the right: x points to the right, from the left of the image",
            lambda true: np.column_stack((width - 1 - true[:, 0], true[:, 1])),
        ),
    ]


def _position_of_marker(markers: MarkerLayout, role: str) -> tuple[str, str, Formula]:
    ahead, right = markers.positions[role]
    return (
        "position of a marker",
        f"its position is that of the {role} marker ({markers.colors[role]}), not that of the "
        "robot's centre",
        lambda true: _beside(true, ahead, right),
    )


def _beside(true: Floats, ahead: float, right: float) -> Floats:
    """Return the points so far ahead and to the right of the robot."""
    c, s = np.cos(true[:, 2]), np.sin(true[:, 2])
    return np.column_stack((true[:, 0] + ahead * c - right * s, true[:, 1] + ahead * s + right * c))


_ARCTAN2 = "arctan2(dy, dx)"
_HEADINGS: list[tuple[str, str, Formula]] = [
    (
        "heading reversed",
        "its heading is off by 180 degrees: the two markers are exchanged, or the "
        "vector between them is reversed",
        lambda h: h + math.pi,
    ),
    (
        "heading turned",
        "its heading is off by 90 degrees to the right: take the direction in which the robot "
        "looks, at right angles to the line between its markers",
        lambda h: h + math.pi / 2,
    ),
    (
        "heading turned",
        "its heading is off by 90 degrees to the left: take the direction in which the robot "
        "looks, at right angles to the line between its markers",
        lambda h: h - math.pi / 2,
    ),
    (
        "heading anticlockwise",
        "its heading has the wrong sign: y points down, and headings are clockwise on the image",
        lambda h: -h,
    ),
    (
        "swapped arguments",
        f"its heading is 90 degrees minus the right one: arctan2 takes y first, {_ARCTAN2}",
        lambda h: math.pi / 2 - h,
    ),
    (
        "heading mirrored",
        "its heading is 180 degrees minus the right one: a sign of dx is wrong in " + _ARCTAN2,
        lambda h: math.pi - h,
    ),
    (
        "heading mirrored",
        "its heading is -90 degrees minus the right one: check the order and the signs in "
        + _ARCTAN2,
        lambda h: -math.pi / 2 - h,
    ),
]
_IN_DEGREES = (
    "heading in degrees",
    "its heading is in degrees: it must be in rad, as arctan2 gives it; see numpy.radians",
)


def _heading_mistake(measured: Floats, true: Floats) -> Iterator[tuple[str, str]]:
    def fits(formula: Formula) -> bool:
        return bool(np.mean(abs(wrap_angle(measured - formula(true))) < _CLOSE[1]) >= _FITS)

    found = list(_first_that_fits(_HEADINGS, fits))
    # A small error of the heading is 57 times as large then.
    if not found and np.mean(abs(wrap_angle(measured - np.degrees(true))) < _ROUGHLY) >= _FITS:
        found = [_IN_DEGREES]
    if not found and np.ptp(measured) < _CLOSE[1]:
        found = [
            ("heading constant", f"its heading is always {np.degrees(measured[0]):.0f} degrees")
        ]
    if not found:
        found = list(_half_turns(measured - true))
    yield from found


def _half_turns(difference: Floats) -> Iterator[tuple[str, str]]:
    """Yield whether some headings are off by 180 degrees, and all others are right."""
    # Twice the angle: half a turn becomes none.
    if np.mean(abs(wrap_angle(2 * difference)) < 2 * _CLOSE[1]) >= _FITS:
        share = np.mean(abs(wrap_angle(difference)) > _FALSE_ANGLE)
        yield (
            "heading reversed at times",
            f"its heading is off by 180 degrees in {share:.0%} of the poses: arctan(dy / dx) "
            f"loses half of the directions, {_ARCTAN2} does not; or the markers are exchanged "
            "at times",
        )
