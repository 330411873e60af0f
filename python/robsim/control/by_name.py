"""The controllers by name, for the command line."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from robsim._core import DriveAround, Spin, Step
from robsim.control.excitation import Chirp, MultiSine, PseudoRandomBinary
from robsim.control.path_following import FollowPath, GoToPoint

Point = tuple[float, float]
Control = Callable[[Step], Any]

#: Those that need no pose, with their default options: ``DriveAround`` is ``drive-around``.
OPEN_LOOP: dict[str, Callable[[], Control]] = {
    re.sub("(?<!^)(?=[A-Z])", "-", kind.__name__).lower(): kind
    for kind in (Spin, DriveAround, PseudoRandomBinary, MultiSine, Chirp)
}
_TO_POINTS: dict[str, Callable[[Sequence[Point]], Control]] = {
    "go-to-point": lambda points: GoToPoint(*points[0]),
    "follow-path": FollowPath,
}

NAMES = (*OPEN_LOOP, *_TO_POINTS)

#: How many points a controller needs; None = one or more. They all need the robot's pose.
POINTS: dict[str, int | None] = {"go-to-point": 1, "follow-path": None}


def controller_named(name: str, points: Sequence[Point] = ()) -> Control:
    """Return a default controller of `NAMES`; those of `POINTS` drive to `points` (x, y) in px."""
    return _TO_POINTS[name](points) if name in _TO_POINTS else OPEN_LOOP[name]()
