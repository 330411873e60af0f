"""The timing of calls side by side, and the table of the results."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from robsim._base.report import Column, Quantity, Report, Row, Table

Call = Callable[[], Any]

_UNITS = {"ms": 1e3, "us": 1e6, "ns": 1e9}  # per second
_OTHERS = {
    "opencv": "OpenCV",
    "components": "components",
    "numpy": "numpy",
    "memory_read": "memory",
}


def _three_digits(value: float) -> str:
    return f"{value:.3g}" if value < 999 else f"{value:,.0f}"


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

    def numbers(self) -> list[float | None]:
        """Return the times, and after each that can be compared how many times ours it is."""
        numbers: list[float | None] = [self.ours]
        for other in _OTHERS:
            time_ = self.others.get(other)
            numbers.append(time_)
            if other != "memory_read":
                numbers.append(None if time_ is None else time_ / self.ours)
        return numbers


@dataclass(frozen=True, kw_only=True)
class BenchResult(Report):
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

    @property
    def title(self) -> str:
        """What was measured."""
        return "Median times in one thread"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The instruction set."""
        return (Quantity("cpu_path", "vector instructions", self.cpu_path),)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The cases, and the rates of whole runs."""
        columns = [Column("ours", "robsim", format=_three_digits)]
        for other, name in _OTHERS.items():
            columns.append(Column(other, name, format=_three_digits, missing=""))
            if other != "memory_read":
                columns.append(Column(f"{other}_ratio", "x", unit="", format=".1f", missing=""))
        cases = [Row(case.name, case.numbers(), unit=case.unit) for case in self.cases]
        rates = [Row(name, [rate]) for name, rate in self.rates.items()]
        rate = Column("steps_per_second", "steps per second", unit="", format=",.0f")
        return (
            Table(key="cases", columns=columns, rows=cases, row_title="task"),
            Table(key="rates", columns=[rate], rows=rates, row_title="Simulation.run"),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read the columns."""
        return ("x: how many times as long as robsim",)


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
