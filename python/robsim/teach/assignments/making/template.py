"""`TEMPLATES`: the ranges that the numbers of a new assignment are drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from robsim.teach.tasks.by_name import task
from robsim.teach.tasks.definition import Task


@dataclass(frozen=True)
class Range:
    """Where a number is drawn from: evenly, and rounded.

    Attributes
    ----------
    least, most : float
        Its limits.
    digits : int
        Decimal places.
    """

    least: float
    most: float
    digits: int = 0

    def draw(self, rng: np.random.Generator) -> float:
        return round(float(rng.uniform(self.least, self.most)), self.digits)


_HEADING = Range(-3.1, 3.1, 2)  # rad

#: What is drawn for each task, and where its parameters stay fair: the shipped solutions are told
#: apart anywhere in there.
TEMPLATES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "park": {
            "goal": (Range(250, 550), Range(250, 550), _HEADING),
            "noise": Range(8, 12, 1),
            "dropout": Range(0.12, 0.18, 2),
            "mismatch": Range(0.08, 0.12, 2),
        },
        "follow": {
            "waypoints": (
                (Range(400, 460), Range(190, 250)),
                (Range(190, 240), Range(190, 250)),
                (Range(190, 240), Range(370, 430)),
            ),
            "noise": Range(8, 12, 1),
            "dropout": Range(0.12, 0.18, 2),
            "mismatch": Range(0.08, 0.12, 2),
        },
        "identify": {
            "mismatch": Range(0.2, 0.3, 2),
            "slip": Range(0.08, 0.12, 3),
            "turn": Range(0.0024, 0.0036, 4),
        },
        "measure": {"noise": Range(26, 34, 1), "dropout": Range(0.1, 0.2, 2)},
        "estimate": {
            "dropout": Range(0.16, 0.24, 2),
            "slip": Range(0.24, 0.36, 2),
            "turn": Range(0.008, 0.012, 3),
        },
    }
)


def draw(name: str, rng: np.random.Generator) -> Task:
    """Return a task with numbers that no other course has."""
    return task(name, **{key: _drawn(one, rng) for key, one in TEMPLATES[name].items()})


def _drawn(ranges: Range | tuple[Any, ...], rng: np.random.Generator) -> Any:
    if isinstance(ranges, Range):
        return ranges.draw(rng)
    return tuple(_drawn(one, rng) for one in ranges)
