"""`Template`: what an assignment is made from, and the ranges that its numbers are drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from robsim.tasks import TASKS, Task, task


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
        """Return a number of the range."""
        return round(float(rng.uniform(self.least, self.most)), self.digits)


@dataclass(frozen=True, kw_only=True)
class Template:
    """What an assignment is made from.

    Attributes
    ----------
    name : str
        Its name in commands.
    title : str
        The title of the assignment.
    task : str
        The name of its task.
    ranges : mapping of str to Range or tuple of Range
        Parameters that are drawn, and where they stay fair: the shipped solutions are told apart
        anywhere in there.
    """

    name: str
    title: str
    task: str
    ranges: Mapping[str, Any] = field(default_factory=dict)

    def draw(self, rng: np.random.Generator) -> Task:
        """Return its task, with numbers that no other course has."""
        return task(self.task, **{name: _drawn(one, rng) for name, one in self.ranges.items()})

    @property
    def kind(self) -> type[Task]:
        """The class of its task."""
        return TASKS[self.task]


def _drawn(ranges: Range | tuple[Any, ...], rng: np.random.Generator) -> Any:
    if isinstance(ranges, Range):
        return ranges.draw(rng)
    return tuple(_drawn(one, rng) for one in ranges)


_HEADING = Range(-3.1, 3.1, 2)  # rad

_ALL = (
    Template(
        name="controller",
        title="Park the robot",
        task="park",
        ranges={
            "goal": (Range(250, 550), Range(250, 550), _HEADING),
            "noise": Range(8, 12, 1),
            "dropout": Range(0.12, 0.18, 2),
            "mismatch": Range(0.08, 0.12, 2),
        },
    ),
    Template(
        name="path",
        title="Drive along a path",
        task="follow",
        ranges={
            "waypoints": (
                (Range(400, 460), Range(190, 250)),
                (Range(190, 240), Range(190, 250)),
                (Range(190, 240), Range(370, 430)),
            ),
            "noise": Range(8, 12, 1),
            "dropout": Range(0.12, 0.18, 2),
            "mismatch": Range(0.08, 0.12, 2),
        },
    ),
    Template(
        name="identification",
        title="Identify the robot",
        task="identify",
        ranges={
            "mismatch": Range(0.2, 0.3, 2),
            "slip": Range(0.08, 0.12, 3),
            "turn": Range(0.0024, 0.0036, 4),
        },
    ),
    Template(
        name="measurement",
        title="Find the robot in noise",
        task="measure",
        ranges={"noise": Range(26, 34, 1), "dropout": Range(0.1, 0.2, 2)},
    ),
    Template(
        name="state",
        title="Where is the robot while nobody sees it?",
        task="estimate",
        ranges={
            "dropout": Range(0.16, 0.24, 2),
            "slip": Range(0.24, 0.36, 2),
            "turn": Range(0.008, 0.012, 3),
        },
    ),
)

#: The templates by name.
TEMPLATES: Mapping[str, Template] = MappingProxyType({one.name: one for one in _ALL})
