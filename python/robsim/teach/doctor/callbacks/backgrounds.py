"""`check_background`: the checks of adjust_background."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from os import PathLike
from typing import Any

import numpy as np

from robsim.base.check_report import CheckReport, Problem
from robsim.simulation import Simulation
from robsim.simulation.slots import WorldSlots
from robsim.teach.doctor._trial import BadResult
from robsim.teach.doctor.callbacks.pose_mistakes import are_right
from robsim.teach.doctor.callbacks.scenes import AREA
from robsim.teach.doctor.callbacks.single_calls import CallbackCalls, check_calls
from robsim.vision.imaging.images import Pixels

_BUDGET = 5.0  # s, once in a run
_PLACES = [(x, y) for x in (150.0, 600.0, 1050.0) for y in (150.0, 600.0, 1050.0)]  # px


def check_background(make: Callable[[], Any] | str | PathLike[str]) -> CheckReport:
    """Check ``adjust_background``, the image of the floor, and report its problems.

    Parameters
    ----------
    make : callable or path
        ``make() -> adjust_background``; for a plain function, ``lambda: adjust_background``. The
        path of a file ``adjust_background.py``, or of its callback folder, is also accepted.

    Returns
    -------
    CheckReport
        True if all checks pass.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable.

    Examples
    --------
    >>> robsim.teach.check_background(lambda: lambda image: image).verdict
    'passed'
    """
    return check_calls(make, WorldSlots.adjust_background, _checks, _BUDGET)


def _checks(calls: CallbackCalls) -> Iterator[Problem | str]:
    size = f"area of {AREA[0]} x {AREA[1]} px"
    image = calls.call(size, _floor(AREA).copy(), read=_read_image)
    if not np.array_equal(image, calls.call(size, _floor(AREA).copy())):
        yield (
            "a second call gives another image: for random marks that repeat, use "
            "numpy.random.default_rng(1)"
        )
    yield from _sight(image)


@cache
def _floor(area: tuple[int, int]) -> Pixels:
    seen: list[Pixels] = []

    def keep(background: Pixels) -> Pixels:
        seen.append(background.copy())
        return background

    Simulation(area=area, adjust_background=keep, seed=1).run(1)
    return seen[0]


def _read_image(image: Any) -> Pixels:
    if image is None:
        raise BadResult("output type", "it returns None: end with return background, the image")
    if not isinstance(image, np.ndarray):
        raise BadResult(
            "output type", f"it returns {type(image).__name__}, not the image, an array"
        )
    if image.shape != (shape := (AREA[1], AREA[0], 3)):
        raise BadResult(
            "output shape",
            f"it returns an array of shape {image.shape}, not {shape}: the image must keep its "
            "size and its three colours",
        )
    if image.dtype != np.uint8:
        hint = ": multiply by 255 and round" if image.max() <= 1 else ""
        text = f"it returns {image.dtype}, not uint8{hint}; see .astype(numpy.uint8)"
        raise BadResult("output type", text)
    return image


def _sight(image: Pixels) -> Iterator[str]:
    poses = np.array([(*place, 0.5 + k) for k, place in enumerate(_PLACES)])
    poses[:, 2] = np.angle(np.exp(1j * poses[:, 2]))
    simulation = Simulation(
        measure=True,
        adjust_background=lambda _: image.copy(),
        evaluate_model=lambda world: poses[world.k],
        start=poses[0],
        control=lambda step: (0, 0),
        seed=1,
    )
    measured = simulation.run(len(poses)).pose_measured
    is_right = are_right(measured, poses)
    if not is_right.all():
        x, y = _PLACES[int(is_right.argmin())]
        yield (
            f"robsim's own measurement finds the robot at {is_right.sum()} of {len(_PLACES)} "
            f"places on this floor, and not at ({x:.0f}, {y:.0f})"
        )
