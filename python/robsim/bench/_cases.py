"""The timing of calls side by side, and the table of the results."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Call = Callable[[], Any]

_UNITS = {"ms": 1e3, "us": 1e6, "ns": 1e9}  # per second
_COLUMNS = {
    "opencv": "OpenCV",
    "components": "OpenCV components",
    "numpy": "numpy",
    "memory_read": "memory read",
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """The median times of one task, by robsim and by others.

    Attributes
    ----------
    name : str
        The task, with the size of the frame.
    ours : float
        Time of robsim.
    others : dict of str to float
        Times of the others for the same task.
    unit : str
        Unit of the times: ``"ms"``, ``"us"`` or ``"ns"``.
    """

    name: str
    ours: float
    others: Mapping[str, float]
    unit: str = "ms"

    def to_dict(self) -> dict[str, float]:
        """Return the times, and the ratio of each other time to ours."""
        numbers = {f"ours_{self.unit}": self.ours}
        for other, value in self.others.items():
            numbers[f"{other}_{self.unit}"] = value
            if other != "memory_read":
                first = other == next(iter(self.others))
                numbers["ratio" if first else f"{other}_ratio"] = value / self.ours
        return numbers

    def row(self) -> str:
        """Return a line of the table."""
        line = f"{self.name:22}{self.ours:9.3f} {self.unit}"
        for other in _COLUMNS:
            value = self.others.get(other)
            text = "" if value is None else f"{value:.3f} ({value / self.ours:.1f} x)"
            line += f"{text:>20}"
        return line.rstrip()


@dataclass(frozen=True, kw_only=True)
class BenchResult:
    """The results of a benchmark run.

    Attributes
    ----------
    cpu_path : str
        The instruction set that the inner loops used.
    cases : tuple of Case
        The timed cases.
    rates : dict of str to float
        Steps per second of `Simulation.run`, by the kind of loop.
    """

    cpu_path: str
    cases: tuple[Case, ...]
    rates: Mapping[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Return name -> numbers."""
        return {
            "cpu_path": self.cpu_path,
            **{case.name: case.to_dict() for case in self.cases},
            **{name: {"steps_per_second": rate} for name, rate in self.rates.items()},
        }

    def __str__(self) -> str:
        titles = "".join(f"{title:>20}" for title in _COLUMNS.values())
        return "\n".join(
            [
                f"one thread, path {self.cpu_path}, medians; in brackets how many times ours",
                f"{'':22}{'robsim':>12}{titles}",
                *(case.row() for case in self.cases),
                "",
                "steps per second of Simulation.run",
                *(f"{name:22}{rate:12,.0f}" for name, rate in self.rates.items()),
            ]
        )


def timed(
    name: str, calls: Mapping[str, Call], rounds: int, *, unit: str = "ms", repeats: int = 1
) -> Case:
    """Time ``"ours"`` and the calls of the others alternately, and return the medians.

    Parameters
    ----------
    name : str
        Name of the case.
    calls : dict of str to callable
        The calls to be timed.
    rounds : int
        Number of timed rounds.
    unit : str
        Unit of the times: ``"ms"``, ``"us"`` or ``"ns"``.
    repeats : int
        Number of repetitions of the task within each call.
    """
    times: dict[str, list[float]] = {who: [] for who in calls}
    for round_ in range(rounds + 2):  # two to warm up
        for who, call in calls.items():
            start = time.perf_counter()
            call()
            seconds = time.perf_counter() - start
            if round_ >= 2:
                times[who].append(_UNITS[unit] * seconds / repeats)
    medians = {who: statistics.median(values) for who, values in times.items()}
    return Case(name=name, ours=medians.pop("ours"), others=medians, unit=unit)
